// SPDX-License-Identifier: Apache-2.0
// Measures how smooth a speed profile is.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace tandem {

/// A speed profile resampled to means over windows of `kWindow` [s], independent of the input rate:
/// comparable for every tick of a simulator and for recorded odometry.
class SpeedProfile {
 public:
  static constexpr double kWindow = 0.1;  ///< [s]

  /// Adds a value at time t [s]; the speed is linear between values. `t` must not decrease.
  void add(double t, double value);
  /// Means of the completed windows, the first of which starts at the first t.
  [[nodiscard]] const std::vector<double>& means() const { return means_; }

 private:
  bool started_ = false;
  double start_ = 0.0, t_ = 0.0, value_ = 0.0;
  double area_ = 0.0;  // integral over the current window
  std::vector<double> means_;
};

/// RMS jerk of a speed profile: √( mean( ((s[k+1] − 2 s[k] + s[k−1]) / h²)² ) ), h = kWindow. Exact
/// for a speed that is quadratic in time. nullopt for fewer than three windows.
[[nodiscard]] std::optional<double> rms_of_second_difference(std::span<const double> speed);

/// Spectral arc length of a speed profile (Balasubramanian, Melendez-Calderon, Roby-Brami, Burdet
/// 2015, eq. 4): minus the arc length of the magnitude spectrum, both axes scaled to 1, up to the
/// highest frequency whose magnitude is 0.05 of the largest. The cut-off is 5 Hz, the Nyquist
/// frequency of windows of 0.1 s (10 Hz in the paper, for hands); zero padding by four powers of
/// two. −1 is the smoothest, lower is less smooth; independent of the scale of speed and time.
/// nullopt if the robot never moved.
[[nodiscard]] std::optional<double> spectral_arc_length(std::span<const double> speed);

}  // namespace tandem
