// SPDX-License-Identifier: Apache-2.0
// The record of a drive: its measures, and its track for the picture.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bringup/scenario/scenario.hpp"
#include "tandem/metrics/metrics.hpp"
#include "tandem/model/obstacle.hpp"

namespace tandem {

/// Path of a moving obstacle.
struct Walk {
  double radius = 0.0;                     ///< [m]
  std::vector<Eigen::Vector2d> p_MO = {};  ///< [m]
};

struct DriveLog {
  DriveResult result;
  std::vector<DriveSample> track;       ///< one sample every 0.05 s
  std::vector<Obstacle> obstacles;      ///< static shapes that the planner received, each once
  std::map<std::uint32_t, Walk> walks;  ///< paths of moving obstacles, by id
};

/// State of a running drive, passed to the progress callback at intervals.
struct Progress {
  double t = 0.0;  ///< simulated [s]
  Twist2 twist;
  double clearance = 0.0;  ///< [m]
  double plan_ms = 0.0;    ///< time of the last solve [ms]
  int collisions = 0;
};

/// Writes a PNG with the map, the fitted obstacles, the paths of people, leader and robot, and the
/// footprint. Throws std::runtime_error if the file cannot be written.
void draw_drive(const Scenario& scenario, const System& system, const DriveLog& log,
                const std::string& png);

/// Adds the obstacles that the planner received to the log. An obstacle that has moved once is
/// recorded as moving from then on.
void remember(DriveLog& log, const std::vector<Obstacle>& seen);

}  // namespace tandem
