// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/stopping_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem {
namespace {

constexpr int kSteps = 10;         // a change of speed is divided into at most this many ranges …
constexpr double kMinStep = 0.01;  // … none shorter than this [s] …
constexpr double kMaxStep = 0.1;   // … and none longer than this, which takes precedence [s]
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct SpeedBounds {
  double weakest, strongest;  // braking [m/s², rad/s²]
  double lag;                 // [s]
};

// High end of the range of one speed, (2). The low end is the high end of the negated speed.
class HighEnd {
 public:
  HighEnd(double speed, const SpeedBounds& bounds) : speed_{speed}, bounds_{bounds} {}

  void forget_targets() { target_ = -kInfinity; }
  void add_target(double target) { target_ = std::max(target_, target); }
  [[nodiscard]] double speed() const { return speed_; }

  // Time until the speed settles, except for the end of an exponential tail [s].
  [[nodiscard]] double settling_time() const {
    if (speed_ < 0.0) return std::max(0.0, std::min(target_, 0.0) - speed_) / bounds_.strongest;
    const double gap = speed_ - std::max(target_, 0.0), knee = bounds_.weakest * bounds_.lag;
    const double tail = std::min(gap, knee);
    return std::max(0.0, gap - knee) / bounds_.weakest +
           (tail > kTailSpeed ? bounds_.lag * std::log(tail / kTailSpeed) : 0.0);
  }

  // Advances by dt; returns the distance travelled [m, rad].
  double advance(double dt) {
    double way = 0.0;
    if (speed_ < 0.0) {
      way = slow_down_in_reverse(dt);
      if (speed_ < 0.0) return way + speed_ * dt;
    }
    if (target_ < speed_) return way + slow_down(dt);
    speed_ = target_;
    return way + speed_ * dt;
  }

 private:
  // Subtracts the time it takes from dt.
  double slow_down_in_reverse(double& dt) {
    const double end = std::min(target_, 0.0), before = speed_;
    if (end <= speed_) return 0.0;
    const double t = (end - speed_) / bounds_.strongest;
    speed_ = t <= dt ? end : speed_ + bounds_.strongest * dt;
    const double used = std::min(t, dt);
    dt -= used;
    return 0.5 * (before + speed_) * used;
  }

  // (1) in the header: constant deceleration down to the knee, exponential decay from there.
  double slow_down(double dt) {
    const double end = std::max(target_, 0.0), knee = bounds_.weakest * bounds_.lag;
    const double t = std::clamp((speed_ - end - knee) / bounds_.weakest, 0.0, dt);
    double way = (speed_ - 0.5 * bounds_.weakest * t) * t;
    speed_ -= bounds_.weakest * t;
    const double rest = dt - t, gap = speed_ - end;
    if (rest <= 0.0) return way;
    const double decay = bounds_.lag > 0.0 ? std::exp(-rest / bounds_.lag) : 0.0;
    speed_ = end + decay * gap;
    return way + end * rest + gap * bounds_.lag * (1.0 - decay);
  }

  double speed_;
  SpeedBounds bounds_;
  double target_ = 0.0;
};

class SpeedRange {
 public:
  SpeedRange(double low, double high, const SpeedBounds& bounds)
      : high_{high, bounds}, low_{-low, bounds} {}

  void forget_targets() {
    high_.forget_targets();
    low_.forget_targets();
  }
  void add_target(double target) {
    high_.add_target(target);
    low_.add_target(-target);
  }
  [[nodiscard]] double settling_time() const {
    return std::max(high_.settling_time(), low_.settling_time());
  }
  // Advances by dt; returns the means of both ends over dt.
  void advance(double dt, double& low, double& high) {
    high = high_.advance(dt) / dt;
    low = -low_.advance(dt) / dt;
  }
  [[nodiscard]] double low() const { return -low_.speed(); }
  [[nodiscard]] double high() const { return high_.speed(); }

 private:
  HighEnd high_, low_;
};

class Builder {
 public:
  Builder(const Twist2& low, const Twist2& high, const StoppingBounds& bounds)
      : v_{low.v, high.v, speed_bounds(bounds.a_brake, bounds)},
        w_{low.w, high.w, speed_bounds(bounds.alpha_brake, bounds)},
        lag_{bounds.motor_lag} {
    envelope_.reserve(4 * kSteps);
  }

  void forget_targets() {
    v_.forget_targets();
    w_.forget_targets();
  }
  void add_target(const Twist2& twist) {
    v_.add_target(twist.v);
    w_.add_target(twist.w);
  }

  // Advances toward the targets for `duration` [s].
  void follow(double duration) {
    const double changing = std::min(duration, settling_time());
    const int most = std::clamp(static_cast<int>(changing / kMinStep), 1, kSteps);
    const int steps = std::max(most, static_cast<int>(std::ceil(changing / kMaxStep)));
    if (changing > 0.0)
      for (int i = 0; i < steps; ++i) append(changing / steps);
    append(duration - changing);
  }
  void follow_to_rest() {
    forget_targets();
    add_target({});
    follow(settling_time());
    if (lag_ > 0.0) envelope_.push_back({{v_.low(), w_.low()}, {v_.high(), w_.high()}, lag_});
  }
  [[nodiscard]] StoppingEnvelope take() { return std::move(envelope_); }

 private:
  static SpeedBounds speed_bounds(double brake, const StoppingBounds& bounds) {
    return {brake, bounds.brake_spread * brake, bounds.motor_lag};
  }
  [[nodiscard]] double settling_time() const {
    return std::max(v_.settling_time(), w_.settling_time());
  }
  void append(double dt) {
    if (dt <= 0.0) return;
    TwistRange range{{}, {}, dt};
    v_.advance(dt, range.low.v, range.high.v);
    w_.advance(dt, range.low.w, range.high.w);
    envelope_.push_back(range);
  }

  SpeedRange v_, w_;
  double lag_;
  StoppingEnvelope envelope_;
};

// The commands sent and the one to try, in order of time.
struct Commands {
  const MotionStart& start;
  double delay;

  [[nodiscard]] std::size_t size() const { return start.sent.size() + 1; }
  [[nodiscard]] Stamped<Twist2> at(std::size_t i) const {
    return i < start.sent.size() ? start.sent[i] : Stamped<Twist2>{start.command, start.now};
  }
  // Time from which zero is in force.
  [[nodiscard]] double end() const { return start.now + start.end; }
  // End of the interval in which command i can still be in force.
  [[nodiscard]] double expiry(std::size_t i) const {
    return i + 1 < size() ? at(i + 1).t + delay : end();
  }
  // Next time after t at which a command begins or ceases to be possible.
  [[nodiscard]] double next_change(double t) const {
    double next = end();
    for (std::size_t i = 0; i < size(); ++i)
      for (const double change : {at(i).t, expiry(i)})
        if (change > t) next = std::min(next, change);
    return next;
  }
  void add_possible(Builder& builder, double t) const {
    for (std::size_t i = 0; i < size(); ++i)
      if (at(i).t <= t && t < expiry(i)) builder.add_target(at(i).value);
    if (t >= at(0).t + delay) return;
    builder.add_target(start.lowest());  // the command before them may still act; it is unknown
    builder.add_target(start.highest());
  }
};

// Distance from `speed` to rest, (1) with the weakest braking and the largest lag.
double stopping_way(double speed, double brake, double lag) {
  const double knee = brake * lag;
  return speed <= knee ? speed * lag : 0.5 * (speed * speed / brake + knee * lag);
}

}  // namespace

Farthest farthest_motion(const MotionStart& start, const StoppingBounds& bounds) {
  Farthest out;
  const auto include = [&](const Twist2& twist) {
    out.speed = std::max(out.speed, std::abs(twist.v));
    out.turn_rate = std::max(out.turn_rate, std::abs(twist.w));
  };
  include(start.lowest());
  include(start.highest());
  include(start.command);
  for (const auto& sent : start.sent) include(sent.value);
  const double time = start.now - start.t_measured + start.end;
  out.path = out.speed * time + stopping_way(out.speed, bounds.a_brake, bounds.motor_lag);
  out.turn =
      out.turn_rate * time + stopping_way(out.turn_rate, bounds.alpha_brake, bounds.motor_lag);
  return out;
}

StoppingEnvelope stopping_envelope(const MotionStart& start, const StoppingBounds& bounds) {
  Builder builder(start.lowest(), start.highest(), bounds);
  const Commands commands{start, bounds.command_delay};
  for (double t = start.t_measured; t < commands.end();) {
    const double next = commands.next_change(t);
    builder.forget_targets();
    commands.add_possible(builder, t);
    builder.follow(next - t);
    t = next;
  }
  builder.follow_to_rest();
  return builder.take();
}

Reach reach(std::span<const TwistRange> envelope) {
  Reach out;
  for (const auto& [low, high, dt] : envelope) {
    out.path += std::max(std::abs(low.v), std::abs(high.v)) * dt;
    out.turn += std::max(std::abs(low.w), std::abs(high.w)) * dt;
    out.path_spread += (high.v - low.v) * dt;
    out.turn_spread += (high.w - low.w) * dt;
    out.time += dt;
  }
  return out;
}

}  // namespace tandem
