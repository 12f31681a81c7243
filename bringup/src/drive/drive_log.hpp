// SPDX-License-Identifier: Apache-2.0
// What a drive leaves behind: its measures, and its track for the picture.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bringup/scenario/scenario.hpp"
#include "tandem/metrics/metrics.hpp"
#include "tandem/model/obstacle.hpp"

namespace tandem {

/// The way of an obstacle that moves.
struct Walk {
  double radius = 0.0;  ///< [m]
  std::vector<Eigen::Vector2d> p_MO = {};
};

struct DriveLog {
  DriveResult result;
  std::vector<DriveSample> track;       ///< every 0.05 s
  std::vector<Obstacle> obstacles;      ///< every shape that stood and that the planner saw, once
  std::map<std::uint32_t, Walk> walks;  ///< of those that moved, by id
};

/// Called now and then during a drive, to show that it lives.
struct Progress {
  double t = 0.0;  ///< simulated [s]
  Twist2 twist;
  double clearance = 0.0;  ///< [m]
  double plan_ms = 0.0;    ///< last solve [ms]
  int collisions = 0;
};

/// Draws map, obstacles as fitted, the ways of people, leader and robot, and the footprint: a PNG.
/// Throws std::runtime_error if the file cannot be written.
void draw_drive(const Scenario& scenario, const System& system, const DriveLog& log,
                const std::string& png);

/// Keeps what the planner sees for the picture. Who has moved once does not count as standing.
void remember(DriveLog& log, const std::vector<Obstacle>& seen);

}  // namespace tandem
