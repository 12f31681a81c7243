// SPDX-License-Identifier: Apache-2.0
// In: discs, obstacles and a guess. Out: the few pairs of them that matter at each stage.
#pragma once

#include <span>
#include <vector>

#include "tandem/local_planner/motion_check.hpp"
#include "tandem/local_planner/ocp/ocp.hpp"

namespace tandem {

/// Which pairs are looked at, and how many are kept.
struct PairLimits {
  double margin = 0.05;  ///< [m] added to each disc
  double moving = 0.0;   ///< [m] added for an obstacle that moves
  double start = 0.0;    ///< [s] from the obstacles' time to stage 0
  double dt = 0.25;      ///< [s]
  double reach = 0.8;    ///< [m] pairs with more clearance than this along the guess are left out
  int max_pairs = 6;     ///< per stage
};

/// The nearest pairs per stage, X_MB being the guess's N poses at the stages' ends.
[[nodiscard]] std::vector<std::vector<Pair>> nearest_pairs(const Body& body,
                                                           std::span<const Obstacle> obstacles,
                                                           std::span<const Pose2> X_MB,
                                                           const PairLimits& limits);

/// Smallest clearance of any pair at each pose [m], at most `reach`: what is left out above counts
/// here.
[[nodiscard]] std::vector<double> clearances(const Body& body, std::span<const Obstacle> obstacles,
                                             std::span<const Pose2> X_MB, const PairLimits& limits);

/// The first of the poses at which a pair misses the margin; their number if none does.
[[nodiscard]] std::size_t first_miss(const Body& body, std::span<const Obstacle> obstacles,
                                     std::span<const Pose2> X_MB, const PairLimits& limits);

}  // namespace tandem
