// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/twist_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

constexpr double kShortestStep = 0.01;  // [s] between two stored samples
constexpr double kRounding = 1e-6;      // [s] tolerance for times that are sums of periods
constexpr Twist2 kStill{0.02, 0.05};    // [m/s, rad/s] a smaller twist has no sign

// Distance along the mean heading: the chord of an arc.
double way_between(const Pose2& a, const Pose2& b) {
  const double heading = a.theta + 0.5 * wrap_angle(b.theta - a.theta);
  return (b.x - a.x) * std::cos(heading) + (b.y - a.y) * std::sin(heading);
}

}  // namespace

void TwistCheck::on_odometry(const Pose2& X_WB, const Twist2& twist, double t) {
  if (!samples_.empty()) {
    const double dt = t - samples_.back().t;
    if (dt >= 0.0 && dt < kShortestStep) return;
    if (dt < 0.0 || dt > kLongestGap) samples_.clear();
  }
  Sample sample{t, X_WB, twist, {}, {}};
  if (!samples_.empty()) {
    const Sample& last = samples_.back();
    const auto extend = [&](const Ways& ways, double posed, double before, double now) {
      const double dt = t - last.t;
      return Ways{ways.posed + posed, ways.low + dt * std::min(before, now),
                  ways.high + dt * std::max(before, now)};
    };
    sample.forward = extend(last.forward, way_between(last.X_WB, X_WB), last.twist.v, twist.v);
    sample.turned =
        extend(last.turned, wrap_angle(X_WB.theta - last.X_WB.theta), last.twist.w, twist.w);
  }
  samples_.push_back(sample);
  while (samples_.front().t < t - kLongestWindow - kRounding) samples_.pop_front();
  v_ = check_windows(&Sample::forward);
  w_ = check_windows(&Sample::turned);
}

void TwistCheck::on_command(const Twist2& twist, double t) {
  if (!commands_.empty() && commands_.back().value == twist) return;
  commands_.push_back({twist, t});
  const double horizon = kLongestWindow + bounds_.age + bounds_.command_delay;
  while (commands_.size() > 1 && commands_[1].t < t - horizon) commands_.pop_front();
}

void TwistCheck::clear() {
  samples_.clear();
  commands_.clear();
  v_ = w_ = {};
}

double TwistCheck::tolerance(double way, double duration) const {
  return 2.0 * bounds_.resolution + std::abs(way) * (bounds_.age / duration + bounds_.slip);  // (1)
}

TwistCheck::Axis TwistCheck::check_windows(Ways Sample::*axis) const {
  Axis out;
  const Sample& newest = samples_.back();
  bool is_shortest = true;
  for (auto from = samples_.rbegin(); from != samples_.rend(); ++from) {
    const double duration = newest.t - from->t;
    if (duration < kShortestWindow - kRounding) continue;
    const Ways &to = newest.*axis, &before = (*from).*axis;
    const double way = to.posed - before.posed, e = tolerance(way, duration);
    if (std::exchange(is_shortest, false)) {
      out.low = (way - e) / duration;
      out.high = (way + e) / duration;
    }
    if (way < to.low - before.low - e || way > to.high - before.high + e)
      out.verdict = Verdict::kContradicted;
    else if (std::abs(way) > 2.0 * e && out.verdict == Verdict::kUndecided)
      out.verdict = Verdict::kConfirmed;
  }
  return out;
}

// Duration of the shortest window, or of the longest if none is long enough yet.
double TwistCheck::duration() const {
  for (auto from = samples_.rbegin(); from != samples_.rend(); ++from)
    if (const double duration = samples_.back().t - from->t;
        duration >= kShortestWindow - kRounding)
      return duration;
  return kLongestWindow;
}

TwistError TwistCheck::error(const Twist2& measured) const {
  if (samples_.empty()) return {};
  const double since = samples_.back().t - duration() - bounds_.age - bounds_.command_delay;
  Twist2 lowest, highest;  // of zero and the commands that can have been in force since then
  for (std::size_t i = 0; i < commands_.size(); ++i) {
    if (i + 1 < commands_.size() && commands_[i + 1].t < since) continue;
    const Twist2& twist = commands_[i].value;
    lowest = {std::min(lowest.v, twist.v), std::min(lowest.w, twist.w)};
    highest = {std::max(highest.v, twist.v), std::max(highest.w, twist.w)};
  }
  const Error v = error_of(v_, measured.v, lowest.v, highest.v, kStill.v);
  const Error w = error_of(w_, measured.w, lowest.w, highest.w, kStill.w);
  return {{v.below, w.below}, {v.above, w.above}};
}

TwistCheck::Error TwistCheck::error_of(const Axis& axis, double measured, double lowest,
                                       double highest, double still) {
  switch (axis.verdict) {
    case Verdict::kConfirmed:
      return {};
    case Verdict::kContradicted: {
      const double low = std::min(axis.low, lowest < 0.0 ? lowest : axis.low);
      const double high = std::max(axis.high, highest > 0.0 ? highest : axis.high);
      return {std::max(0.0, measured - low), std::max(0.0, high - measured)};
    }
    case Verdict::kUndecided:
      if (measured < -still && lowest > -still && highest > 0.0) return {0.0, highest - measured};
      if (measured > still && highest < still && lowest < 0.0) return {measured - lowest, 0.0};
  }
  return {};
}

bool TwistCheck::is_contradicted() const {
  return v_.verdict == Verdict::kContradicted || w_.verdict == Verdict::kContradicted;
}

Twist2 TwistCheck::least_speed() const {
  const auto least = [](const Axis& axis) { return std::max({0.0, axis.low, -axis.high}); };
  return {least(v_), least(w_)};
}

}  // namespace tandem
