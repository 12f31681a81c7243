// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/drive.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

struct Limits {
  double up, down, lag;
};

// Speed after dt of first-order motion toward `target` with limited acceleration, (1) in drive.hpp.
double follow(double speed, double target, const Limits& limits, double dt) {
  const bool slowing = speed != 0.0 && (target * speed < 0.0 || std::abs(target) < std::abs(speed));
  const double limit = (slowing ? limits.down : limits.up) * dt;
  const double gain = limits.lag > 0.0 ? 1.0 - std::exp(-dt / limits.lag) : 1.0;
  return speed + std::clamp(gain * (target - speed), -limit, limit);
}

}  // namespace

Drive::Drive(const DriveParams& params, const RobotParams& robot, unsigned seed)
    : params_{params}, robot_{robot}, random_{seed} {}

void Drive::command(const Twist2& twist, double t) {
  if (!is_finite(twist)) return;
  queue_.push_back({limit(twist, robot_), t});
}

void Drive::step(double t, double dt) {
  take_commands(t);
  if (t >= slip_until_) draw_slip(t);
  const double lag = params_.lag_fraction * robot_.motor_lag;
  const Limits forward{params_.a_drive, params_.brake_factor * robot_.a_brake, lag};
  const Limits turn{params_.alpha_drive, params_.turn_brake_factor * robot_.alpha_brake, lag};
  const Twist2 now = to_body(speeds_, robot_.wheel_separation);
  const Twist2& target = in_force_.value;
  speeds_ = to_wheels({follow(now.v, target.v, forward, dt), follow(now.w, target.w, turn, dt)},
                      robot_.wheel_separation);
}

bool Drive::is_at_rest() const {
  constexpr double kRest = 1e-6;  // [m/s], below which an exponential has all but ended
  const auto is_stop = [](const auto& command) { return command.value == Twist2{}; };
  return std::abs(speeds_.left) < kRest && std::abs(speeds_.right) < kRest && is_stop(in_force_) &&
         std::all_of(queue_.begin(), queue_.end(), is_stop);
}

Twist2 Drive::twist_over_ground() const {
  return to_body({slip_.left * speeds_.left, slip_.right * speeds_.right}, robot_.wheel_separation);
}

// The base's command time-out starts when a command arrives.
void Drive::take_commands(double t) {
  const double delay = params_.command_delay_fraction * robot_.command_delay;
  while (!queue_.empty() && queue_.front().t + delay <= t) {
    in_force_ = {queue_.front().value, queue_.front().t + delay};
    queue_.pop_front();
  }
  if (robot_.base_timeout > 0.0 && in_force_.age(t) > robot_.base_timeout) in_force_.value = {};
}

void Drive::draw_slip(double t) {
  std::uniform_real_distribution<double> factor(1.0 - params_.slip, 1.0 + params_.slip);
  slip_.left = factor(random_);
  slip_.right = factor(random_);
  slip_until_ = t + params_.slip_time;
}

}  // namespace tandem
