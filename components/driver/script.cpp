// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/script.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tandem/driver/wander.hpp"

namespace tandem {
namespace {

constexpr double kCreeps = 0.1;           // [m] from the end: the stick reaches end_stick,
constexpr double kSlowsWithin = 0.8;      // [m] over which it falls to that value
constexpr double kHoldsLeader = 0.3;      // [m] before its maximum lead a leader slows down
constexpr double kMaxBack = 0.5;          // [m] maximum decrease of progress per sample
constexpr double kMaxAhead = 1.0;         // [m] maximum increase
constexpr double kStandsDistance = 0.03;  // [m] smaller motion counts as standing
constexpr double kStandsAngle = 0.1;      // [rad]
constexpr double kEager = 0.4;            // [1] extra stick of an impatient person
constexpr double kEagerAhead = 0.5;       // [m, rad] their extra lead beyond the end
constexpr double kBackOutTime = 2.0;      // [s]
constexpr double kBackOutStick = 0.5;     // [1]
constexpr double kLeastTurn = 0.15;       // [1] minimum stick that turns the robot
constexpr double kRounding = 1e-6;        // [s] rounding of a sum of sample times
constexpr double kNoiseTime = 0.3;        // [s] correlation time of the hand's noise

template <class... Actions>
struct Overloaded : Actions... {
  using Actions::operator()...;
};
template <class... Actions>
Overloaded(Actions...) -> Overloaded<Actions...>;  // clang 14 does not deduce it

// Direction of travel along the path [rad]: the rear leads when reversing.
double facing(const PathPhase& path, const Pose2& X) {
  return path.direction > 0.0 ? X.theta : X.theta + std::numbers::pi;
}

}  // namespace

Script::Script(const std::string& text, const NavigatorParams& params, const Footprint& outline,
               unsigned seed)
    : params_{params}, phases_{read_script(text, outline)}, random_{seed} {
  check(params_);
}

Hand Script::steer(const Pose2& X_MB, const Pose2& X_MS, double t) {
  look(X_MB, X_MS, t);
  if (!started_) begin(t);
  started_ = true;
  if (!arrived() && is_done(t)) {
    ++phase_;
    begin(t);
  }
  if (arrived()) return {0.0, 0.0, false};
  lose_patience(t);
  return with_noise(t < back_out_until_ ? back_out() : meant());
}

void Script::look(const Pose2& X_MB, const Pose2& X_MS, double t) {
  seen_.push_back({t, X_MB, X_MS});
  while (seen_.size() > 1 && seen_[1].t <= t - params_.reaction_delay) seen_.pop_front();
}

void Script::begin(double t) {
  phase_start_ = back_out_until_ = t;
  progress_ = steered_progress_ = 0.0;
  be_patient(t);
}

void Script::be_patient(double t) {
  is_eager_ = false;
  moved_ = {seen_.front().X_MB, t};
}

bool Script::is_done(double t) {
  if (t - phase_start_ >= phases_[phase_].time - kRounding) return true;
  return std::visit(Overloaded{[&](const PathPhase& path) { return is_there(path); },
                               [&](const TurnPhase& turn) { return is_there(turn); },
                               [](const PushPhase&) { return false; }},
                    phases_[phase_].action);
}

bool Script::is_there(const PathPhase& path) {
  const auto along = [&](const Pose2& X, double last) {
    return path.route.nearest(X.position(), last - kMaxBack, last + kMaxAhead);
  };
  progress_ = along(seen_.front().X_MB, progress_);
  steered_progress_ = along(seen_.front().X_MS, steered_progress_);
  return path.route.length() - (path.leader_arrives ? steered_progress_ : progress_) <=
         path.tolerance;
}

bool Script::is_there(const TurnPhase& turn) const {
  return std::abs(wrap_angle(turn.heading - seen_.front().X_MB.theta)) <= turn.tolerance;
}

Hand Script::meant() const {
  return std::visit(Overloaded{[&](const PathPhase& path) { return meant(path); },
                               [&](const TurnPhase& turn) { return meant(turn); },
                               [](const PushPhase& push) {
                                 return Hand{push.linear, push.angular, true};
                               }},
                    phases_[phase_].action);
}

// Pure pursuit. Near the end of the route the target lies beyond it, so that its bearing stays well
// defined.
Hand Script::meant(const PathPhase& path) const {
  const Pose2& X_MS = seen_.front().X_MS;
  const double push = pushed(path);
  const Eigen::Vector2d d =
      path.route.point_at(steered_progress_ + params_.preview) - X_MS.position();
  const double heading =
      push > 0.0 ? std::atan2(d.y(), d.x()) : path.route.heading_at(steered_progress_);
  const double bearing = wrap_angle(heading - facing(path, X_MS));
  const double forward = std::max(0.0, std::cos(bearing));
  return {path.direction * push * forward * forward,
          std::clamp(NavigatorParams::kTurnGain * bearing, -1.0, 1.0), true};
}

// Stick deflection along the route [1]; 0 while a leader waits for its robot.
double Script::pushed(const PathPhase& path) const {
  const Seen& seen = seen_.front();
  const double left = path.route.length() - steered_progress_;
  const double slow = std::clamp((left - kCreeps) / kSlowsWithin, 0.0, 1.0);
  double stick = path.end_stick + slow * (path.stick - path.end_stick);
  if (is_eager_) stick = std::min(1.0, path.stick + kEager);
  if (!seen.leads()) return stick;
  const double lead =
      left > 0.0 ? progress_ + params_.preview - steered_progress_
                 : kEagerAhead * is_eager_ -
                       (seen.X_MS.position() - path.route.point_at(path.route.length())).norm();
  return stick * std::clamp(lead / kHoldsLeader, 0.0, 1.0);
}

Hand Script::meant(const TurnPhase& turn) const {
  const double error = wrap_angle(turn.heading - seen_.front().X_MS.theta);
  const bool leads = seen_.front().leads();
  if (leads && !is_eager_ && std::abs(error) <= turn.tolerance) return {0.0, 0.0, true};
  const double most = is_eager_ ? std::min(1.0, turn.stick + kEager) : turn.stick;
  const double stick =
      std::clamp(NavigatorParams::kTurnGain * std::abs(error), std::min(kLeastTurn, most), most);
  return {0.0, std::copysign(stick, error), true};
}

// Moves opposite to the blocked direction.
Hand Script::back_out() const {
  if (const auto* path = std::get_if<PathPhase>(&phases_[phase_].action))
    return {-path->direction * kBackOutStick, 0.0, true};
  const auto& turn = std::get<TurnPhase>(phases_[phase_].action);
  const double error = wrap_angle(turn.heading - seen_.front().X_MB.theta);
  return {0.0, -std::copysign(kBackOutStick, error), true};
}

// Push phases are exempt: they push on purpose, whether anything moves or not.
void Script::lose_patience(double t) {
  const Pose2& X_MB = seen_.front().X_MB;
  const bool moved = (X_MB.position() - moved_.value.position()).norm() > kStandsDistance ||
                     std::abs(wrap_angle(X_MB.theta - moved_.value.theta)) > kStandsAngle;
  if (std::holds_alternative<PushPhase>(phases_[phase_].action)) return;
  if (moved || t < back_out_until_) return be_patient(t);
  if (moved_.age(t) < params_.patience) return;
  if (is_eager_) back_out_until_ = t + kBackOutTime;
  const bool pushes_harder = !is_eager_;
  be_patient(t);
  is_eager_ = pushes_harder;
}

// The noise grows with the deflection.
Hand Script::with_noise(Hand hand) {
  const auto next = [&](double noise) {
    return wander(noise, params_.stick_noise, kNoiseTime, params_.rate, normal_(random_));
  };
  const double deflection = std::hypot(hand.linear, hand.angular);
  noise_linear_ = next(noise_linear_);
  noise_angular_ = next(noise_angular_);
  return {std::clamp(hand.linear + deflection * noise_linear_, -1.0, 1.0),
          std::clamp(hand.angular + deflection * noise_angular_, -1.0, 1.0), hand.holds};
}

}  // namespace tandem
