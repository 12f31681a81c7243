// SPDX-License-Identifier: Apache-2.0
#include "safety_filter/stopping_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr int kRampSteps = 10;         // a ramp is cut into so many constant twists …
constexpr double kMinRampStep = 0.01;  // … but none shorter than this [s]
constexpr double kRounding = 1e-12;    // [m/s, rad/s]
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One end of the range of one speed. The low end is the high end of the mirrored speed.
class End {
 public:
  End(double speed, double sign, double weakest, double spread)
      : sign_{sign}, speed_{sign_ * speed}, weakest_{weakest}, strongest_{spread * weakest} {}

  void forget_targets() { target_ = -kInfinity; }
  void add_target(double target) { target_ = std::max(target_, sign_ * target); }

  // Changes that take no time, (1).
  void jump() {
    if (speed_ >= 0.0 && target_ > speed_) speed_ = target_;
  }
  [[nodiscard]] double ramp_time() const { return std::max(0.0, (end() - speed_) / rate()); }
  // Mean speed of the next dt of ramp.
  double advance(double dt) {
    const double before = speed_;
    speed_ = approach(speed_, end(), std::abs(rate()) * dt);
    // A ramp in parts may miss its end by rounding; short of zero the next jump would not come.
    if (std::abs(speed_ - end()) < kRounding) speed_ = end();
    return sign_ * 0.5 * (before + speed_);
  }

 private:
  [[nodiscard]] double end() const {
    return speed_ >= 0.0 ? std::max(target_, 0.0) : std::clamp(target_, speed_, 0.0);
  }
  [[nodiscard]] double rate() const { return speed_ >= 0.0 ? -weakest_ : strongest_; }

  double sign_, speed_, weakest_, strongest_;
  double target_ = 0.0;
};

// A speed at a share of its range: between its two ends.
class Channel {
 public:
  Channel(double speed, double share, double weakest, double spread)
      : share_{share}, high_{speed, 1.0, weakest, spread}, low_{speed, -1.0, weakest, spread} {}

  void forget_targets() {
    high_.forget_targets();
    low_.forget_targets();
  }
  void add_target(double target) {
    high_.add_target(target);
    low_.add_target(target);
  }
  void jump() {
    high_.jump();
    low_.jump();
  }
  [[nodiscard]] double ramp_time() const {
    return std::max(share_ > 0.0 ? high_.ramp_time() : 0.0, share_ < 1.0 ? low_.ramp_time() : 0.0);
  }
  double advance(double dt) {
    return share_ * high_.advance(dt) + (1.0 - share_) * low_.advance(dt);
  }

 private:
  double share_;
  End high_, low_;
};

class Builder {
 public:
  Builder(const Channel& v, const Channel& w) : v_{v}, w_{w} {
    motion_.reserve(2 * kRampSteps + 8);
  }

  void forget_targets() {
    v_.forget_targets();
    w_.forget_targets();
  }
  void add_target(const Twist2& twist) {
    v_.add_target(twist.v);
    w_.add_target(twist.w);
  }

  // Goes on toward the targets for `duration`.
  void follow(double duration) {
    jump();
    const double ramp = std::min(duration, ramp_time());
    const int steps = std::clamp(static_cast<int>(ramp / kMinRampStep), 1, kRampSteps);
    if (ramp > 0.0)
      for (int i = 0; i < steps; ++i) append(ramp / steps);
    append(duration - ramp);
  }
  void follow_to_rest() {
    forget_targets();
    add_target({});
    follow(ramp_time());
  }
  [[nodiscard]] Motion take() { return std::move(motion_); }

 private:
  [[nodiscard]] double ramp_time() const { return std::max(v_.ramp_time(), w_.ramp_time()); }
  void jump() {
    v_.jump();
    w_.jump();
  }
  void append(double dt) {
    if (dt <= 0.0) return;
    const double v = v_.advance(dt), w = w_.advance(dt);
    motion_.push_back({{v, w}, dt});
    jump();
  }

  Channel v_, w_;
  Motion motion_;
};

// End of the time in which command i can still be in force.
double expiry(const MotionStart& start, std::size_t i, double delay) {
  return delay + (i + 1 < start.sent.size() ? start.sent[i + 1].t : start.now);
}

// Next time after t at which a command begins or ceases to be possible.
double next_change(const MotionStart& start, double t, double delay) {
  double next = start.now > t ? start.now : start.now + delay;
  for (std::size_t i = 0; i < start.sent.size(); ++i)
    for (const double change : {start.sent[i].t, expiry(start, i, delay)})
      if (change > t) next = std::min(next, change);
  return next;
}

}  // namespace

Motion possible_motion(const MotionStart& start, const StoppingBounds& bounds, double v, double w) {
  Builder builder(Channel(start.measured.v, v, bounds.a_brake, bounds.brake_spread),
                  Channel(start.measured.w, w, bounds.alpha_brake, bounds.brake_spread));
  const double settled = start.now + bounds.delay;  // from then on only `command` is in force
  for (double t = start.t_measured; t < settled;) {
    builder.forget_targets();
    for (std::size_t i = 0; i < start.sent.size(); ++i)
      if (start.sent[i].t <= t && t < expiry(start, i, bounds.delay))
        builder.add_target(start.sent[i].twist);
    if (start.sent.empty() || start.sent.front().t > t) builder.add_target(start.measured);
    if (t >= start.now) builder.add_target(start.command);
    const double next = next_change(start, t, bounds.delay);
    builder.follow(next - t);
    t = next;
  }
  builder.forget_targets();
  builder.add_target(start.command);
  builder.follow(start.hold);
  builder.follow_to_rest();
  return builder.take();
}

Spread spread(const Motion& low, const Motion& high) {
  Spread out;
  for (const auto& [twist, dt] : high) {
    out.path += twist.v * dt;
    out.turn += twist.w * dt;
  }
  for (const auto& [twist, dt] : low) {
    out.path -= twist.v * dt;
    out.turn -= twist.w * dt;
  }
  return {std::abs(out.path), std::abs(out.turn)};
}

Reach reach(const MotionStart& start, const StoppingBounds& bounds) {
  double v = std::max(std::abs(start.measured.v), std::abs(start.command.v));
  double w = std::max(std::abs(start.measured.w), std::abs(start.command.w));
  for (const auto& sent : start.sent) {
    if (sent.t > start.now) continue;
    v = std::max(v, std::abs(sent.twist.v));
    w = std::max(w, std::abs(sent.twist.w));
  }
  const double time = start.now - start.t_measured + bounds.delay + start.hold;
  return {v * time + 0.5 * v * v / bounds.a_brake, w * time + 0.5 * w * w / bounds.alpha_brake,
          time + std::max(v / bounds.a_brake, w / bounds.alpha_brake)};
}

}  // namespace tandem
