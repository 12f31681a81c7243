// SPDX-License-Identifier: Apache-2.0
// Estimates the delay between commands sent and their effect in odometry.
#pragma once

#include <deque>
#include <optional>

#include "tandem/model/robot.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Estimates the loop delay, from sending a command until its effect appears in odometry
/// (transport, motor lag, sensor). A new command acts this much later than the measured pose.
///
/// The delay is the shift d for which the commands c fit the measurements m best,
///
///   min_d Σ_i ((m_v(t_i) − c_v(t_i − d)) / v_max)² + ((m_ω(t_i) − c_ω(t_i − d)) / ω_max)²     (1)
///
/// over the last seconds (matching by least squares, as Knapp & Carter 1976 do by correlation). A
/// first-order lag counts as a delay of its time constant, or slightly less if the commands change
/// on the same time scale. The estimate is not updated while the measured twist hardly changes, or
/// if the residual of (1) stays large, as for a robot that is blocked.
class DelayEstimator {
 public:
  explicit DelayEstimator(const RobotParams& robot) : v_max_{robot.v_max}, w_max_{robot.w_max} {}

  /// A command sent at t [s], in force until the next. Ignored if not finite or older than the
  /// last.
  void on_command(const Twist2& twist, double t);
  /// A twist received at t [s]. Ignored if not finite or not newer than the last.
  void on_measurement(const Twist2& twist, double t);

  /// Call after the clock jumps back: discards commands and measurements, keeps the delay.
  void forget();

  /// Smoothed delay [s]; nullopt before the first estimate.
  [[nodiscard]] std::optional<double> delay() const { return delay_; }

 private:
  [[nodiscard]] double residual(double delay) const;
  [[nodiscard]] bool is_excited() const;
  [[nodiscard]] std::optional<double> best_delay() const;

  double v_max_, w_max_;
  std::deque<Stamped<Twist2>> sent_, measured_;  // oldest first
  static constexpr double kAtOnce = -1e300;      // [s]
  double next_look_ = kAtOnce;
  std::optional<double> delay_;
};

}  // namespace tandem
