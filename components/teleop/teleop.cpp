// SPDX-License-Identifier: Apache-2.0
#include "teleop/teleop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

constexpr double kCallsBack = 0.3;  // [1] of the stick's way: less moves the leader bit by bit
constexpr double kBeside = 0.1;     // [m] the leader is neither before nor behind the robot

double axis(std::span<const float> axes, int index, double deadzone) {
  if (index < 0 || static_cast<std::size_t>(index) >= axes.size()) return 0.0;
  const double value = axes[static_cast<std::size_t>(index)];
  if (!std::isfinite(value) || std::abs(value) <= deadzone) return 0.0;
  const double travel = (std::min(std::abs(value), 1.0) - deadzone) / (1.0 - deadzone);
  return std::copysign(travel, value);
}

bool pressed(std::span<const int> buttons, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < buttons.size() &&
         buttons[static_cast<std::size_t>(index)] != 0;
}

// Whether the push, forward or backward, leads back to the robot.
bool leads_back(double push, const Pose2& X_ML, const Pose2& X_MB) {
  const Eigen::Vector2d ahead{std::cos(X_ML.theta), std::sin(X_ML.theta)};
  return std::copysign(1.0, push) * ahead.dot(X_ML.position() - X_MB.position()) < -kBeside;
}

}  // namespace

Stick read_stick(std::span<const float> axes, std::span<const int> buttons,
                 const TeleopParams& params) {
  return {axis(axes, params.axis_linear, params.gains.deadzone),
          axis(axes, params.axis_angular, params.gains.deadzone),
          params.deadman_button < 0 || pressed(buttons, params.deadman_button),
          pressed(buttons, params.end_button)};
}

JoyValues joy_values(const Stick& stick, const TeleopParams& params) {
  JoyValues joy;
  const auto put = [](auto& values, int index, auto value) {
    if (index < 0) return;
    const auto at = static_cast<std::size_t>(index);
    if (values.size() <= at) values.resize(at + 1);
    values[at] = value;
  };
  const auto turned = [](double value, double scale) {
    return static_cast<float>(scale < 0.0 ? -value : value);
  };
  put(joy.axes, params.axis_linear, turned(stick.linear, params.gains.scale_linear));
  put(joy.axes, params.axis_angular, turned(stick.angular, params.gains.scale_angular));
  put(joy.buttons, params.deadman_button, stick.deadman ? 1 : 0);
  put(joy.buttons, params.end_button, stick.end ? 1 : 0);
  return joy;
}

Teleop::Teleop(const TeleopParams& params) : params_{params} { check(params_); }

void Teleop::set_gains(const StickGains& gains) {
  check(gains);
  params_.gains = gains;
}

std::optional<Intent> Teleop::on_stick(const Stick& stick, const std::optional<Pose2>& X_MB,
                                       double t) {
  const bool was_held = std::exchange(held_, stick.deadman);
  const double dt = t - std::exchange(last_, t);  // below zero: the clock was set back
  const bool goes_on = was_held && 0.0 <= dt && dt <= params_.joy_timeout;
  if (!held_ || !goes_on) X_ML_.reset();
  if (!held_) return was_held ? std::optional<Intent>{Intent{}} : std::nullopt;
  if (X_MB)
    drive_leader(stick, *X_MB, goes_on ? dt : 0.0);
  else
    X_ML_.reset();
  return Intent{
      {params_.gains.scale_linear * stick.linear, params_.gains.scale_angular * stick.angular},
      X_ML_};
}

// Who throws the stick round wants the robot to turn back now, not when the leader has come all the
// way from the end of its leash.
void Teleop::call_leader_back(double push, const Pose2& X_MB) {
  if (std::abs(push) < kCallsBack) return;
  const double before = std::exchange(pushed_, push);
  if (before * push < 0.0 && leads_back(push, *X_ML_, X_MB))
    X_ML_ = Pose2{X_MB.x, X_MB.y, X_ML_->theta};
}

void Teleop::drive_leader(const Stick& stick, const Pose2& X_MB, double dt) {
  if (!X_ML_) {
    X_ML_ = X_MB;
    pushed_ = 0.0;
  }
  call_leader_back(stick.linear, X_MB);
  const Twist2 twist{params_.gains.leader_scale_linear * stick.linear,
                     params_.gains.leader_scale_angular * stick.angular};
  *X_ML_ = integrate(*X_ML_, twist, dt);
  X_ML_->theta = wrap_angle(X_ML_->theta);
  const Eigen::Vector2d p_BL_M = X_ML_->position() - X_MB.position();
  if (p_BL_M.norm() <= params_.gains.leash) return;
  const Eigen::Vector2d p_ML = X_MB.position() + params_.gains.leash * p_BL_M.normalized();
  X_ML_->x = p_ML.x();
  X_ML_->y = p_ML.y();
}

}  // namespace tandem
