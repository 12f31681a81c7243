// SPDX-License-Identifier: Apache-2.0
#include "tandem/teleop/teleop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tandem/model/dead_zone.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kCallsBack = 0.3;   // [1] deflection; smaller pushes do not call the leader back
constexpr double kBeside = 0.1;      // [m] the leader is neither before nor behind the robot
constexpr double kStands = 0.05;     // [m/s] a slower robot counts as standing
constexpr double kOvershoot = 1.05;  // [1] fraction of its range that an axis may reach
const Twist2 kFastest{5.0, 10.0};    // [m/s, rad/s] limit of the leader, as in the gains' ranges

bool is_there(std::size_t size, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

// Value in [−1, 1] if the device honours `axis_range`; nullopt if the axis is missing.
std::optional<double> axis_value(std::span<const float> axes, int index,
                                 const TeleopParams& params) {
  if (!is_there(axes.size(), index)) return std::nullopt;
  return axes[static_cast<std::size_t>(index)] / params.axis_range;
}

double axis(std::span<const float> axes, int index, const TeleopParams& params) {
  const double value = axis_value(axes, index, params).value_or(0.0);
  if (!std::isfinite(value) || std::abs(value) > kOvershoot) return 0.0;
  return beyond_dead_zone(value, params.gains.deadzone);
}

bool pressed(std::span<const int> buttons, int index) {
  return is_there(buttons.size(), index) && buttons[static_cast<std::size_t>(index)] != 0;
}

std::string missing(const char* what, int index, const char* parameter) {
  return std::string{"joy has no "} + what + " " + std::to_string(index) + " (" + parameter + ")";
}

void check_axis(JoyCheck& joy, std::span<const float> axes, int index, const char* parameter,
                const TeleopParams& params) {
  const auto value = axis_value(axes, index, params);
  const std::string axis = std::string{"axis "} + std::to_string(index) + " of joy";
  if (!value) {
    joy.trouble = missing("axis", index, parameter);
  } else if (!std::isfinite(*value)) {
    joy.trouble = axis + " is not finite";
  } else if (std::abs(*value) > kOvershoot) {
    joy.trouble = axis + " is beyond axis_range";
    joy.beyond_range = true;
  }
  joy.at_rest = joy.at_rest && (!value || std::abs(*value) <= params.gains.deadzone);
}

// Whether the push, forward or backward, moves the leader toward the robot.
bool leads_back(double push, const Pose2& X_ML, const Pose2& X_MB) {
  const Eigen::Vector2d ahead{std::cos(X_ML.theta), std::sin(X_ML.theta)};
  return std::copysign(1.0, push) * ahead.dot(X_ML.position() - X_MB.position()) < -kBeside;
}

}  // namespace

Stick read_stick(std::span<const float> axes, std::span<const int> buttons,
                 const TeleopParams& params) {
  return {axis(axes, params.axis_linear, params), axis(axes, params.axis_angular, params),
          params.deadman_button < 0 || pressed(buttons, params.deadman_button),
          pressed(buttons, params.end_button)};
}

JoyCheck check_joy(std::span<const float> axes, std::span<const int> buttons,
                   const TeleopParams& params) {
  JoyCheck joy;
  joy.at_rest =
      is_there(axes.size(), params.axis_linear) || is_there(axes.size(), params.axis_angular);
  check_axis(joy, axes, params.axis_angular, "axis_angular", params);
  check_axis(joy, axes, params.axis_linear, "axis_linear", params);
  if (params.deadman_button >= 0 && !is_there(buttons.size(), params.deadman_button))
    joy.trouble = missing("button", params.deadman_button, "deadman_button");
  if (params.end_button >= 0 && !is_there(buttons.size(), params.end_button))
    joy.remark = missing("button", params.end_button, "end_button");
  return joy;
}

JoyValues joy_values(const Stick& stick, const TeleopParams& params) {
  JoyValues joy;
  const auto put = [](auto& values, int index, auto value) {
    if (index < 0) return;
    const auto at = static_cast<std::size_t>(index);
    if (values.size() <= at) values.resize(at + 1);
    values[at] = value;
  };
  const auto turned = [&](double value, double scale) {
    return static_cast<float>(params.axis_range * (scale < 0.0 ? -value : value));
  };
  put(joy.axes, params.axis_linear, turned(stick.linear, params.gains.scale_linear));
  put(joy.axes, params.axis_angular, turned(stick.angular, params.gains.scale_angular));
  put(joy.buttons, params.deadman_button, stick.deadman ? 1 : 0);
  put(joy.buttons, params.end_button, stick.end ? 1 : 0);
  return joy;
}

Teleop::Teleop(const TeleopParams& params, const std::optional<RobotParams>& robot)
    : params_{params}, robot_{robot} {
  check(params_);
  if (robot_) check(*robot_);
}

void Teleop::set_gains(const StickGains& gains) {
  check(gains);
  params_.gains = gains;
}

std::optional<Intent> Teleop::on_stick(const Stick& stick, const std::optional<Pose2>& X_MB,
                                       double t, const Twist2& measured) {
  const bool was_held = std::exchange(held_, stick.deadman);
  if (!held_) {
    steered_.reset();
    if (hand_.value == Hand::kStick) hand_.value = Hand::kNone;
    return was_held ? std::optional<Intent>{Intent{}} : std::nullopt;
  }
  // Without a dead-man, a stick at rest counts as not held.
  const bool steers = params_.deadman_button >= 0 || stick.linear != 0.0 || stick.angular != 0.0;
  if (!steers && hand_.value == Hand::kTwist && hand_.fresh(t, params_.joy_timeout))
    return std::nullopt;
  if (steers) steered_ = {true, t};
  const StickGains& gains = params_.gains;
  // A negative gain reverses the axis.
  const double push = gains.leader_scale_linear < 0.0 ? -stick.linear : stick.linear;
  lead(Hand::kStick,
       {{gains.leader_scale_linear * stick.linear, gains.leader_scale_angular * stick.angular},
        push,
        measured},
       X_MB, t);
  return Intent{{gains.scale_linear * stick.linear, gains.scale_angular * stick.angular}, X_ML_};
}

std::optional<Pose2> Teleop::on_twist(const Twist2& twist, const std::optional<Pose2>& X_MB,
                                      double t, const Twist2& measured) {
  if (steered_.fresh(t, params_.joy_timeout)) return std::nullopt;
  const Twist2 leader{std::clamp(twist.v, -kFastest.v, kFastest.v),
                      std::clamp(twist.w, -kFastest.w, kFastest.w)};
  const double full = std::abs(params_.gains.scale_linear);
  lead(Hand::kTwist, {leader, full > 0.0 ? leader.v / full : leader.v, measured}, X_MB, t);
  return X_ML_;
}

// The leader restarts at the robot when another hand takes over and after a silence.
void Teleop::lead(Hand hand, const Steering& steering, const std::optional<Pose2>& X_MB, double t) {
  const auto before = std::exchange(hand_, {hand, t});
  const bool goes_on = before.value == hand && before.fresh(t, params_.joy_timeout);
  if (!goes_on || !X_MB) X_ML_.reset();
  Steering now = steering;
  now.rests = push_.rests(asks_to_stop(steering.twist, steering.measured), t);
  if (X_MB) drive_leader(now, *X_MB, goes_on ? before.age(t) : 0.0);
}

// Reversing the stick means that the robot should turn back now, not after the leader has travelled
// back from the end of its leash.
void Teleop::call_leader_back(double push, const Pose2& X_MB) {
  if (std::abs(push) < kCallsBack) return;
  const double before = std::exchange(pushed_, push);
  if (before * push < 0.0 && leads_back(push, *X_ML_, X_MB))
    X_ML_ = Pose2{X_MB.x, X_MB.y, X_ML_->theta};
}

// The braking path is an arc, half as long as at constant speed.
Pose2 Teleop::braking_point(const Pose2& X_MB, const Twist2& measured) const {
  if (!robot_) return X_MB;
  const Twist2 moves = limit(measured, *robot_);
  const double time =
      std::max(std::abs(moves.v) / robot_->a_brake, std::abs(moves.w) / robot_->alpha_brake);
  return integrate(X_MB, moves, 0.5 * time);
}

// If the stick only turns while the robot stands, the leader turns at the robot's position. Not
// while it drives: a person who turns hard at speed would be braked (BARN at 2 m/s took 9 %
// longer).
Pose2 Teleop::driven(const Pose2& X_ML, const Steering& steering, const Pose2& X_MB,
                     double dt) const {
  if (steering.rests) return braking_point(X_MB, steering.measured);
  const bool turns = robot_ && steering.twist.v == 0.0 && steering.twist.w != 0.0 &&
                     std::abs(steering.measured.v) < kStands;
  if (near_) return integrate(X_MB, steering.twist, dt);
  const Pose2 from = turns ? Pose2{X_MB.x, X_MB.y, X_ML.theta} : X_ML;
  return integrate(from, robot_ ? limit(steering.twist, *robot_) : steering.twist, dt);
}

void Teleop::drive_leader(const Steering& steering, const Pose2& X_MB, double dt) {
  if (!X_ML_) {
    X_ML_ = X_MB;
    pushed_ = 0.0;
  }
  call_leader_back(steering.push, X_MB);
  X_ML_ = driven(*X_ML_, steering, X_MB, dt);
  X_ML_->theta = wrap_angle(X_ML_->theta);
  const Eigen::Vector2d p_BL_M = X_ML_->position() - X_MB.position();
  if (p_BL_M.norm() <= params_.gains.leash) return;
  const Eigen::Vector2d p_ML = X_MB.position() + params_.gains.leash * p_BL_M.normalized();
  X_ML_->x = p_ML.x();
  X_ML_->y = p_ML.y();
}

}  // namespace tandem
