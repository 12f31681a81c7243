// SPDX-License-Identifier: Apache-2.0
// Gives the robot's pose at the time a scan was taken.
#pragma once

#include <deque>
#include <optional>

#include "tandem/model/se2.hpp"

namespace tandem {

/// Poses of the last second. Stamps [s] are those of the messages, not arrival times: for a robot
/// that turns at 1 rad/s a wall 5 m away moves by 0.25 m in 50 ms.
class PoseHistory {
 public:
  static constexpr double kKept = 1.0;      ///< [s]
  static constexpr double kMaxAhead = 0.3;  ///< [s] longest extrapolation of a pose

  void add(const Pose2& X_MB, const Twist2& twist, double stamp) {
    if (!samples_.empty() && stamp < samples_.back().stamp) samples_.clear();  // clock set back
    samples_.push_back({X_MB, twist, stamp});
    while (samples_.front().stamp < stamp - kKept) samples_.pop_front();
  }

  /// The last pose before the stamp, extrapolated by its twist; nullopt without a pose within
  /// kMaxAhead.
  [[nodiscard]] std::optional<Pose2> at(double stamp) const {
    for (auto it = samples_.rbegin(); it != samples_.rend(); ++it)
      if (it->stamp <= stamp)
        return stamp - it->stamp <= kMaxAhead
                   ? std::optional{integrate(it->X_MB, it->twist, stamp - it->stamp)}
                   : std::nullopt;
    return std::nullopt;
  }

  /// The newest stamp [s]; nullopt before the first pose.
  [[nodiscard]] std::optional<double> newest() const {
    return samples_.empty() ? std::nullopt : std::optional{samples_.back().stamp};
  }

 private:
  struct Sample {
    Pose2 X_MB;
    Twist2 twist;
    double stamp;
  };
  std::deque<Sample> samples_;
};

}  // namespace tandem
