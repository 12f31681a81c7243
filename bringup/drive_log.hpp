// SPDX-License-Identifier: Apache-2.0
// What a drive leaves behind: its measures, and its track for the picture.
#pragma once

#include <string>
#include <vector>

#include "bringup/metrics.hpp"
#include "bringup/scenario.hpp"
#include "model/obstacle.hpp"

namespace tandem {

struct DriveLog {
  DriveResult result;
  std::vector<DriveSample> track;   ///< every 0.05 s
  std::vector<Obstacle> obstacles;  ///< every shape the planner ever saw, once
};

/// Called now and then during a drive, to show that it lives.
struct Progress {
  double t = 0.0;  ///< simulated [s]
  Twist2 twist;
  double clearance = 0.0;  ///< [m]
  double plan_ms = 0.0;    ///< last solve [ms]
  int collisions = 0;
};

/// Draws map, obstacles as fitted, the leader's and the robot's path and the footprint into a PNG.
/// Throws std::runtime_error if the file cannot be written.
void draw_drive(const Scenario& scenario, const System& system, const DriveLog& log,
                const std::string& png);

/// Keeps shapes that stand by their id, so that the picture shows each once.
void remember(std::vector<Obstacle>& known, const std::vector<Obstacle>& seen);

}  // namespace tandem
