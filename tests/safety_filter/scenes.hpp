// SPDX-License-Identifier: Apache-2.0
// Worlds and robots for the safety filter's tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "tandem/diff_drive_sim/diff_drive_sim.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/robot.hpp"
#include "tandem/safety_filter/safety_filter.hpp"

namespace tandem::test {

using Random = std::mt19937;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline int pick(Random& random, int count) {
  return std::uniform_int_distribution<int>(0, count - 1)(random);
}

/// Free square world of side `size` around the origin.
inline Grid free_grid(double size, double resolution = 0.05) {
  Grid grid;
  grid.resolution = resolution;
  grid.width = grid.height = static_cast<int>(size / resolution);
  grid.origin = {-0.5 * size, -0.5 * size};
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                    Cell::kFree);
  return grid;
}

/// Occupies every cell whose centre satisfies `inside(x, y)`.
template <class Inside>
void occupy(Grid& grid, const Inside& inside) {
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix) {
      const Eigen::Vector2d p = grid.center(ix, iy);
      if (inside(p.x(), p.y()))
        grid.cells[static_cast<std::size_t>(iy) * static_cast<std::size_t>(grid.width) +
                   static_cast<std::size_t>(ix)] = Cell::kOccupied;
    }
}

inline std::shared_ptr<const StaticMap> as_map(Grid grid) {
  return std::make_shared<const StaticMap>(std::move(grid));
}

inline const RobotParams kMir{};  // the MiR 100
// front of the MiR 100's outline, ahead of base_link [m]
inline constexpr double kBumper = 0.038 + 0.445;

/// A wall whose near face is the line x = 1.5.
inline std::shared_ptr<const StaticMap> wall_ahead() {
  Grid grid = free_grid(8.0);
  occupy(grid, [](double x, double) { return x > 1.5 && x < 1.7; });
  return as_map(std::move(grid));
}

inline void add_border(Grid& grid) {
  const double edge = -grid.origin.x() - 2.0 * grid.resolution;
  occupy(grid, [&](double x, double y) { return std::max(std::abs(x), std::abs(y)) > edge; });
}

inline void add_pole(Grid& grid, double cx, double cy, double radius) {
  occupy(grid, [&](double x, double y) { return std::hypot(x - cx, y - cy) < radius; });
}

/// Poles as in a forest, single cells, blocks, or walls with gaps, all inside the world's border.
inline std::shared_ptr<const StaticMap> random_map(Random& random, double resolution = 0.05) {
  Grid grid = free_grid(5.0, resolution);
  add_border(grid);
  const auto place = [&] { return uniform(random, -2.4, 2.4); };
  switch (pick(random, 4)) {
    case 0:
      for (int i = 0; i < 5; ++i) add_pole(grid, place(), place(), uniform(random, 0.05, 0.3));
      break;
    case 1:
      for (int i = 0; i < 10; ++i) add_pole(grid, place(), place(), 0.6 * resolution);
      break;
    case 2:
      for (int i = 0; i < 4; ++i) {
        const double cx = place(), cy = place(), a = uniform(random, 0.1, 0.6);
        const double b = uniform(random, 0.05, 0.4), angle = uniform(random, 0.0, 3.0);
        const double c = std::cos(angle), s = std::sin(angle);
        occupy(grid, [&](double x, double y) {
          return std::abs(c * (x - cx) + s * (y - cy)) < a &&
                 std::abs(-s * (x - cx) + c * (y - cy)) < b;
        });
      }
      break;
    default: {
      const double angle = uniform(random, 0.0, 3.0), c = std::cos(angle), s = std::sin(angle);
      const double gap = uniform(random, 0.45, 0.9), half_door = uniform(random, 0.3, 0.6);
      occupy(grid, [&](double x, double y) {  // corridor along `angle` with a door on its left
        const double along = c * x + s * y, across = -s * x + c * y;
        const bool wall = std::abs(std::abs(across) - gap - 0.05) < 0.05;
        return wall && !(across > 0.0 && std::abs(along) < half_door);
      });
    }
  }
  return as_map(std::move(grid));
}

/// A robot of any plausible size, with its axle anywhere inside its outline.
inline RobotParams random_robot(Random& random) {
  RobotParams robot;
  robot.length = uniform(random, 0.4, 1.1);
  robot.width = uniform(random, 0.3, 0.7);
  robot.center_x = uniform(random, -0.35, 0.35) * robot.length;
  robot.wheel_separation = uniform(random, 0.7, 0.95) * robot.width;
  robot.v_max = uniform(random, 0.4, 1.5);
  robot.v_min = -uniform(random, 0.2, 0.8);
  robot.w_max = uniform(random, 0.6, 2.0);
  robot.a_brake = uniform(random, 0.8, 2.5);
  robot.alpha_brake = uniform(random, 1.5, 6.0);
  const double slow = pick(random, 4) ? 1.0 : 5.0;  // motors of 0.4 s, a link of 0.3 s
  robot.motor_lag = slow * uniform(random, 0.0, 0.08);
  robot.command_delay = slow * uniform(random, 0.0, 0.06);
  robot.sensor_delay = slow * uniform(random, 0.0, 0.06);
  robot.base_timeout = uniform(random, 0.06, 0.2);
  return robot;
}

/// A fraction of a bound, often 0 or 1.
inline double fraction(Random& random) {
  const int choice = pick(random, 4);
  return choice == 0 ? 0.0 : choice == 1 ? 1.0 : uniform(random, 0.0, 1.0);
}

/// A base that makes full use of the filter's bounds.
inline DiffDriveSimParams random_base(Random& random, const SafetyFilterParams& filter) {
  DiffDriveSimParams sim;
  sim.max_step = 0.01;
  sim.sensor_delay_fraction = fraction(random);
  sim.drive.command_delay_fraction = fraction(random);
  sim.drive.lag_fraction = fraction(random);
  sim.drive.a_drive = uniform(random, 0.8, 6.0);
  sim.drive.alpha_drive = uniform(random, 1.5, 12.0);
  sim.drive.brake_factor = 1.0 + fraction(random) * (filter.brake_spread - 1.0);
  sim.drive.turn_brake_factor = 1.0 + fraction(random) * (filter.brake_spread - 1.0);
  sim.drive.slip = fraction(random) * filter.slip;
  sim.drive.slip_time = uniform(random, 0.05, 0.5);
  return sim;
}

/// Draws a pose in the map with at least `clearance` around the outline; false if none was found.
inline bool find_free_pose(Random& random, const StaticMap& map, const Footprint& footprint,
                           double clearance, Pose2& X_MB) {
  for (int attempt = 0; attempt < 200; ++attempt) {
    X_MB = {uniform(random, -2.2, 2.2), uniform(random, -2.2, 2.2),
            uniform(random, -std::numbers::pi, std::numbers::pi)};
    if (map.clearance(footprint, X_MB, clearance + 0.01) > clearance) return true;
  }
  return false;
}

}  // namespace tandem::test
