// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/emergency_stop.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr double kAtRest = 0.02;  // [m/s, rad/s] a larger command is steering

}  // namespace

void EmergencyStop::on_signal(bool pressed) {
  pressed_ = pressed;
  if (pressed) latched_ = must_restart_ = true;
}

bool EmergencyStop::release() {
  if (!pressed_) latched_ = false;
  return !latched_;
}

void EmergencyStop::on_user(const Twist2& twist, double t) {
  received_user_ = true;
  if (std::abs(twist.v) <= kAtRest && std::abs(twist.w) <= kAtRest) {
    if (!rest_since_) rest_since_ = t;
    return;
  }
  if (!latched_ && has_let_go(t)) must_restart_ = false;
  rest_since_.reset();
}

EmergencyStop::Awaits EmergencyStop::awaits(double now, bool autonomous) {
  if (latched_) return Awaits::kRelease;
  if (autonomous && (has_let_go(now) || !received_user_)) must_restart_ = false;
  if (!must_restart_) return Awaits::kNothing;
  // Letting go alone does not start the robot: with the dead-man button held and the stick at rest,
  // a planner with a goal would drive at once.
  return has_let_go(now) ? Awaits::kSteering : Awaits::kLettingGo;
}

void EmergencyStop::on_time_jump(double now) {
  if (rest_since_) rest_since_ = now;
}

}  // namespace tandem
