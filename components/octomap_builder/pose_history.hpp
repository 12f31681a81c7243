// SPDX-License-Identifier: Apache-2.0
// In: where the robot was, by the stamps of odometry. Out: where it was when a scan was taken.
#pragma once

#include <deque>
#include <optional>

#include "tandem/model/se2.hpp"

namespace tandem {

/// Poses of the last second. Stamps [s] are those of the messages, not times of arrival: a robot
/// that turns by 1 rad/s sees a wall 5 m away move by 0.25 m in 50 ms.
class PoseHistory {
 public:
  static constexpr double kKept = 1.0;       ///< [s]
  static constexpr double kMostAhead = 0.3;  ///< [s] no pose is carried on for longer

  void add(const Pose2& X_MB, const Twist2& twist, double stamp) {
    if (!samples_.empty() && stamp < samples_.back().stamp) samples_.clear();  // time began anew
    samples_.push_back({X_MB, twist, stamp});
    while (samples_.front().stamp < stamp - kKept) samples_.pop_front();
  }

  /// The last pose before the stamp, carried on by its twist; nothing without one near enough.
  [[nodiscard]] std::optional<Pose2> at(double stamp) const {
    for (auto it = samples_.rbegin(); it != samples_.rend(); ++it)
      if (it->stamp <= stamp)
        return stamp - it->stamp <= kMostAhead
                   ? std::optional{integrate(it->X_MB, it->twist, stamp - it->stamp)}
                   : std::nullopt;
    return std::nullopt;
  }

  /// The newest stamp [s]; nothing before the first pose.
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
