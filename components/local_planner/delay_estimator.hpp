// SPDX-License-Identifier: Apache-2.0
// In: commands as they are sent, twists as they are measured. Out: the delay between the two.
#pragma once

#include <deque>
#include <optional>

#include "tandem/model/robot.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Measures the delay of the loop: from a command to the moment its effect is seen in the odometry
/// (transport, motor lag, sensor). That is how far ahead of the measured pose a new command acts.
///
/// The delay is the shift d that explains the measurements m by the commands c best,
///
///   min_d Σ_i ((m_v(t_i) − c_v(t_i − d)) / v_max)² + ((m_ω(t_i) − c_ω(t_i − d)) / ω_max)²     (1)
///
/// over the last seconds (matching by least squares, as Knapp & Carter 1976 do by correlation). A
/// first-order lag counts as a delay of its time constant, a little less where the commands change
/// as quickly as it does. Nothing is concluded from commands that
/// hardly change, nor where (1) leaves much unexplained, as for a robot that is held.
class DelayEstimator {
 public:
  explicit DelayEstimator(const RobotParams& robot) : v_max_{robot.v_max}, w_max_{robot.w_max} {}

  /// A command sent at t, in force until the next. Times do not decrease; not finite: ignored.
  void on_command(const Twist2& twist, double t);
  /// A twist that arrived at t.
  void on_measurement(const Twist2& twist, double t);

  /// The clock was set back: commands and measurements are of no known time. The delay stays.
  void forget();

  /// Smoothed delay [s]; none before the first conclusion.
  [[nodiscard]] std::optional<double> delay() const { return delay_; }

 private:
  struct Sample {
    Twist2 twist;
    double t;
  };

  [[nodiscard]] double misfit(double delay) const;
  [[nodiscard]] bool is_excited() const;
  [[nodiscard]] std::optional<double> best_delay() const;

  double v_max_, w_max_;
  std::deque<Sample> sent_, measured_;       // oldest first
  static constexpr double kAtOnce = -1e300;  // [s]
  double next_look_ = kAtOnce;
  std::optional<double> delay_;
};

}  // namespace tandem
