// SPDX-License-Identifier: Apache-2.0
// Selects the few disc-obstacle pairs that need a constraint at each stage of the OCP.
#pragma once

#include <span>
#include <vector>

#include "tandem/local_planner/motion_check.hpp"
#include "tandem/local_planner/ocp/ocp.hpp"

namespace tandem {

/// Which pairs are considered, and how many are kept.
struct PairLimits {
  double margin = 0.05;  ///< [m] added to each disc's radius
  double moving = 0.0;   ///< [m] added to that for a moving obstacle
  double start = 0.0;    ///< [s] from the obstacles' timestamp to the start of stage 0
  double dt = 0.25;      ///< [s] length of a stage
  double reach = 0.8;    ///< [m] pairs with more clearance than this at the guess are ignored
  int max_pairs = 6;     ///< per stage
};

/// The nearest pairs of each stage, nearest first. X_MB: the guess's N poses at the ends of the
/// stages.
[[nodiscard]] std::vector<std::vector<Pair>> nearest_pairs(const Body& body,
                                                           std::span<const Obstacle> obstacles,
                                                           std::span<const Pose2> X_MB,
                                                           const PairLimits& limits);

/// Smallest clearance over all pairs at each pose [m], capped at `reach`. `max_pairs` does not
/// apply.
[[nodiscard]] std::vector<double> clearances(const Body& body, std::span<const Obstacle> obstacles,
                                             std::span<const Pose2> X_MB, const PairLimits& limits);

/// Index of the first pose at which a pair violates its margin; X_MB.size() if there is none.
[[nodiscard]] std::size_t first_miss(const Body& body, std::span<const Obstacle> obstacles,
                                     std::span<const Pose2> X_MB, const PairLimits& limits);

}  // namespace tandem
