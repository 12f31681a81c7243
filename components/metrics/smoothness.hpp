// SPDX-License-Identifier: Apache-2.0
// In: a speed over time. Out: how smooth it is.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace tandem {

/// A speed as means over windows of `kWindow` [s], whatever the rate at which it is given: the
/// same for a simulator's every tick and for recorded odometry.
class SpeedProfile {
 public:
  static constexpr double kWindow = 0.1;

  /// The speed goes straight from the last value to this one. `t` must not decrease.
  void add(double t, double value);
  /// Means of the windows that are over, the first from the first t on.
  [[nodiscard]] const std::vector<double>& means() const { return means_; }

 private:
  bool started_ = false;
  double start_ = 0.0, t_ = 0.0, value_ = 0.0;
  double area_ = 0.0;  // of the window that is not over
  std::vector<double> means_;
};

/// Jerk of a speed profile: √( mean( ((s[k+1] − 2 s[k] + s[k−1]) / h²)² ) ), h = kWindow. Exact for
/// a speed that is quadratic in time. Empty below three windows.
[[nodiscard]] std::optional<double> rms_of_second_difference(std::span<const double> speed);

/// Spectral arc length of a speed profile (Balasubramanian, Melendez-Calderon, Roby-Brami, Burdet
/// 2015, eq. 4): minus the length of the curve of the magnitude spectrum, both axes scaled to 1,
/// up to the highest frequency whose magnitude is 0.05 of the largest. Cut-off 5 Hz, the highest
/// that windows of 0.1 s can show (there 10 Hz, for hands); zero padding by four powers of two.
/// −1 is the smoothest, lower is less smooth; scaling speed or time changes nothing. Empty for a
/// robot that never moved.
[[nodiscard]] std::optional<double> spectral_arc_length(std::span<const double> speed);

}  // namespace tandem
