// SPDX-License-Identifier: Apache-2.0
// In: where the leader is, cycle by cycle. Out: the way it took, as far as it is still ahead.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tandem/local_planner/ocp/pairs.hpp"

namespace tandem {

/// Where the person's leader drove since the place beside which the robot is now. Devalla 2020,
/// §5.1 asks for it: the leader's way, not only its pose, says what the person means.
class Trail {
 public:
  /// The leader moved to p_ML, the robot to p_MB. A leader that comes back to an earlier place of
  /// its trail takes back what lay between; one that jumps begins anew.
  void extend(const Eigen::Vector2d& p_ML, const Eigen::Vector2d& p_MB);
  void clear() { points_.clear(); }

  /// Points kSpacing apart up to the leader and `onward` from there, without those at which the
  /// body's smallest disc would miss the margin, the last apart: a leader is a ghost and drives
  /// through what stands in its way.
  [[nodiscard]] std::vector<Eigen::Vector2d> free_points(
      const Body& body, std::span<const Obstacle> obstacles, const PairLimits& limits,
      std::span<const Eigen::Vector2d> onward = {}) const;

  static constexpr double kSpacing = 0.05;  ///< [m]

 private:
  std::vector<Eigen::Vector2d> points_;
};

/// The point `ahead` metres along the trail from its point nearest to p_MQ [m].
struct OnTrail {
  Eigen::Vector2d p_MT;
  Eigen::Vector2d ahead = {1.0, 0.0};  ///< the trail's direction there, of length 1
  bool bridges = false;  ///< where points are missing, so that the robot has to find its own way
};
[[nodiscard]] OnTrail along(std::span<const Eigen::Vector2d> trail, const Eigen::Vector2d& p_MQ,
                            double ahead);

}  // namespace tandem
