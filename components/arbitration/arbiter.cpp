// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/arbiter.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/model/reasons.hpp"

namespace tandem {
namespace {

// std::lerp is finite for all finite twists; a.v + share_of_b * (b.v - a.v) can overflow.
Twist2 mix(const Twist2& a, const Twist2& b, double share_of_b) {
  return {std::lerp(a.v, b.v, share_of_b), std::lerp(a.w, b.w, share_of_b)};
}

// [s] without steering that counts as letting go. Shorter rests occur while driving: a stick passes
// its centre, and a key is released between two presses.
constexpr double kLetsGo = 1.0;
constexpr double kNodeTimeout = 0.5;  // [s] of silence after which a node is gone rather than late

bool is_rest(const Twist2& twist, double threshold) {
  return std::abs(twist.v) <= threshold && std::abs(twist.w) <= threshold;
}

Decision stop(ArbitrationReason reason) { return {{}, Source::kNone, reason, 0.0}; }

// Whether the input was received once and is silent now.
template <class T>
bool is_silent(const Stamped<T>& input, double now, double timeout) {
  return input.t > Stamped<T>::kNever && !input.fresh(now, timeout);
}

}  // namespace

const std::vector<std::string>& policies() {
  static const std::vector<std::string> names{"manual", "shared", "blend", "adaptive",
                                              "autonomous"};
  return names;
}

const char* name(Policy policy) { return policies().at(static_cast<std::size_t>(policy)).c_str(); }

const char* name(Source source) {
  switch (source) {
    case Source::kNone:
      return "none";
    case Source::kUser:
      return "user";
    case Source::kShared:
      return "shared";
    case Source::kBlend:
      return "blend";
    case Source::kNav:
      return "nav";
  }
  return "?";
}

const char* name(ArbitrationReason reason) {
  switch (reason) {
    case ArbitrationReason::kFollowsSource:
      return text_of(Reason::kFollowsSource);
    case ArbitrationReason::kHandover:
      return text_of(Reason::kHandover);
    case ArbitrationReason::kUserTakesOver:
      return text_of(Reason::kUserTakesOver);
    case ArbitrationReason::kEmergencyStop:
      return text_of(Reason::kEmergencyStop);
    case ArbitrationReason::kLetGoFirst:
      return text_of(Reason::kLetGoFirst);
    case ArbitrationReason::kSteerFirst:
      return text_of(Reason::kSteerFirst);
    case ArbitrationReason::kUserSilent:
      return text_of(Reason::kUserSilent);
    case ArbitrationReason::kSharedSilent:
      return text_of(Reason::kSharedSilent);
    case ArbitrationReason::kAllSilent:
      return text_of(Reason::kNoCommand);
    case ArbitrationReason::kClockSilent:
      return text_of(Reason::kClockSilent);
  }
  return "?";
}

Policy policy_from(const std::string& text) {
  const auto& names = policies();
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<Policy>(found - names.begin());
  std::string all;
  for (const std::string& known : names) all += (all.empty() ? "" : ", ") + known;
  throw std::invalid_argument("policy '" + text + "' is not one of {" + all + "}");
}

Arbiter::Arbiter(const ArbiterParams& params)
    : params_{params},
      policy_{policy_from(params.policy)},
      stop_{std::max(kLetsGo, params.user_timeout)},
      handover_{params.handover_time} {
  check(params_);
}

void Arbiter::set_blend(const BlendParams& blend) {
  check(blend);
  params_.blend = blend;
}

void Arbiter::on_user(const Twist2& twist, double t) {
  if (!is_finite(twist)) return;
  user_ = {twist, t};
  performance_.on_user(twist, t, params_.adaptive);
  stop_.on_user(twist, t);
}
void Arbiter::on_shared(const Twist2& twist, double t) {
  if (is_finite(twist)) shared_ = {twist, t};
}
void Arbiter::on_nav(const Twist2& twist, double t) {
  if (is_finite(twist)) nav_ = {twist, t};
}

void Arbiter::on_clearance(double clearance, double t) {
  if (!std::isnan(clearance)) clearance_ = {clearance, t};
}

void Arbiter::on_emergency_stop(bool pressed) {
  stop_.on_signal(pressed);
  if (pressed && policy_ == Policy::kAutonomous) policy_ = Policy::kShared;
}

bool Arbiter::set_policy(Policy policy) {
  if (stop_.latched() && policy == Policy::kAutonomous) return false;
  policy_ = policy;
  return true;
}

Decision Arbiter::decide(double now) {
  Decision decision = ramp(choose(now), now);
  decision.performance = performance_.performance();
  last_ = decision;
  last_time_ = now;
  return decision;
}

void Arbiter::on_time_jump(double now) {
  for (auto* input : {&user_, &shared_, &nav_}) input->reset();
  for (auto* trouble : {&stick_, &planner_, &filter_}) trouble->reset();
  clearance_.reset();
  stop_.on_time_jump(now);
  handover_.end_ramp();
  last_time_ = now;
}

bool Arbiter::steers(double now) const {
  return user_is_fresh(now) && !is_rest(user_.value, params_.takeover_threshold);
}

Decision Arbiter::choose(double now) {
  // Pressing the stop ends autonomy, so kAutonomous here was chosen after it.
  switch (stop_.awaits(now, policy_ == Policy::kAutonomous)) {
    case EmergencyStop::Awaits::kRelease:
      return stop(ArbitrationReason::kEmergencyStop);
    case EmergencyStop::Awaits::kLettingGo:
      return stop(stop_.received_user() ? ArbitrationReason::kLetGoFirst
                                        : ArbitrationReason::kUserSilent);
    case EmergencyStop::Awaits::kSteering:
      return stop(user_is_fresh(now) ? ArbitrationReason::kSteerFirst
                                     : ArbitrationReason::kUserSilent);
    case EmergencyStop::Awaits::kNothing:
      return choose_by_policy(now);
  }
  return stop(ArbitrationReason::kEmergencyStop);
}

Decision Arbiter::choose_by_policy(double now) {
  if (policy_ == Policy::kAutonomous) return choose_autonomous(now);
  if (!user_is_fresh(now)) return stop(ArbitrationReason::kUserSilent);
  if (policy_ == Policy::kManual)
    return {user_.value, Source::kUser, ArbitrationReason::kFollowsSource, 0.0};
  if (!shared_.fresh(now, params_.shared_timeout)) return stop(ArbitrationReason::kSharedSilent);
  if (policy_ == Policy::kShared)
    return {shared_.value, Source::kShared, ArbitrationReason::kFollowsSource, 1.0};
  if (policy_ == Policy::kAdaptive) return adapt(now);
  const double disagreement =
      std::hypot(user_.value.v - shared_.value.v, user_.value.w - shared_.value.w) /
      params_.blend.disagreement;
  return blend(now, params_.blend.min, disagreement);
}

// Low clearance still gives the planner full authority at once; the person's errors act only over
// time.
Decision Arbiter::adapt(double now) {
  performance_.update(shared_.value, params_.blend.disagreement, now, params_.adaptive);
  return blend(now, performance_.share(params_.adaptive), 0.0);
}

Decision Arbiter::choose_autonomous(double now) const {
  if (steers(now)) return {user_.value, Source::kUser, ArbitrationReason::kUserTakesOver, 0.0};
  if (nav_.fresh(now, params_.nav_timeout))
    return {nav_.value, Source::kNav, ArbitrationReason::kFollowsSource, 0.0};
  if (shared_.fresh(now, params_.shared_timeout))
    return {shared_.value, Source::kShared, ArbitrationReason::kFollowsSource, 1.0};
  return stop(ArbitrationReason::kAllSilent);
}

// The planner's share grows with danger (little clearance) and with disagreement: a planner that
// departs from the person's command has probably seen something the person has not.
Decision Arbiter::blend(double now, double least, double disagreement) {
  const bool known = clearance_.fresh(now, params_.shared_timeout);
  const double danger = known ? 1.0 - clearance_.value / params_.blend.clearance : 1.0;
  const double target = std::clamp(std::max(danger, disagreement), least, 1.0);
  const double step = params_.blend.rate * std::max(0.0, now - last_time_);
  alpha_ = std::clamp(target, alpha_ - step, alpha_ + step);
  return {mix(user_.value, shared_.value, alpha_), Source::kBlend,
          ArbitrationReason::kFollowsSource, alpha_};
}

// A stop is never ramped, and a robot that stood starts at the command itself.
Decision Arbiter::ramp(Decision decision, double now) {
  if (decision.source == Source::kNone) {
    handover_.stop();
    return decision;
  }
  const bool changed = last_.source != Source::kNone && decision.source != last_.source;
  const Twist2 chosen = decision.command;
  decision.command = handover_.follow(chosen, changed, now);
  if (decision.command != chosen && decision.reason == ArbitrationReason::kFollowsSource)
    decision.reason = ArbitrationReason::kHandover;
  return decision;
}

std::string Arbiter::why(const Decision& decision, double now) const {
  const std::string own = name(decision.reason);
  const bool stops_here = decision.source == Source::kNone;
  if (stops_here && decision.reason != ArbitrationReason::kUserSilent) return own;
  if (stops_here && !stick_.value.empty() && stick_.fresh(now, kNodeTimeout)) return stick_.value;
  if (const std::string trouble = trouble_of_filter(now); !trouble.empty()) return trouble;
  const bool planned = decision.source == Source::kShared || decision.source == Source::kBlend;
  if (planned && !planner_.value.empty() && planner_.fresh(now, kNodeTimeout))
    return "planner: " + planner_.value;
  return own;
}

std::string Arbiter::trouble_of_filter(double now) const {
  if (is_silent(filter_, now, kNodeTimeout)) return text_of(Reason::kFilterSilent);
  return filter_.value.empty() ? std::string{} : "safety filter: " + filter_.value;
}

std::vector<std::string> Arbiter::silent_sources(double now) const {
  std::vector<std::string> silent;
  if (is_silent(user_, now, params_.user_timeout)) silent.emplace_back("cmd_vel_user");
  if (is_silent(shared_, now, params_.shared_timeout)) silent.emplace_back("cmd_vel_shared");
  if (is_silent(nav_, now, params_.nav_timeout)) silent.emplace_back("cmd_vel_nav");
  return silent;
}

}  // namespace tandem
