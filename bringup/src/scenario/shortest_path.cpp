// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/shortest_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/local_planner/local_planner_node.hpp"
#include "tandem/map/path_search.hpp"

namespace tandem {
namespace {

constexpr double kThinner = 0.02;   // [m] between the radii tried
constexpr double kPathStep = 0.01;  // [m] along the path

using Points = std::vector<Eigen::Vector2d>;

// Radius of the largest disc about B's origin inside the part, negative if the origin is outside.
double inner_radius(const ConvexPolygon& part) {
  double radius = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < part.size(); ++i) {
    const Eigen::Vector2d& a = part[i];
    const Eigen::Vector2d edge = part[(i + 1) % part.size()] - a;
    radius = std::min(radius, (edge.y() * a.x() - edge.x() * a.y()) / edge.norm());
  }
  return radius;
}

// The largest such radius over all parts: the origin never gets closer to an obstacle than this.
double inner_radius(const Footprint& footprint) {
  double radius = 0.0;
  for (const auto& part : footprint.parts) radius = std::max(radius, inner_radius(part));
  return radius;
}

bool is_free(const StaticMap& map, const Eigen::Vector2d& a, const Eigen::Vector2d& z,
             double radius) {
  const int steps = 1 + static_cast<int>((z - a).norm() / kPathStep);
  for (int i = 1; i < steps; ++i)
    if (map.distance(a + (z - a) * i / steps) < radius) return false;
  return true;
}

Points pulled_taut(const StaticMap& map, const Points& way, double radius) {
  Points taut{way.front()};
  for (std::size_t at = 0; at + 1 < way.size();) {
    std::size_t next = way.size() - 1;
    while (next > at + 1 && !is_free(map, way[at], way[next], radius)) --next;
    at = next;
    taut.push_back(way[at]);
  }
  return taut;
}

double length_to(const Goal& goal, const Points& way) {
  double length = 0.0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const int steps = 1 + static_cast<int>((way[i] - way[i - 1]).norm() / kPathStep);
    const Eigen::Vector2d step = (way[i] - way[i - 1]) / steps;
    for (int k = 0; k < steps; ++k) {
      if (is_at(goal, way[i - 1] + k * step)) return length;
      length += step.norm();
    }
  }
  return length;
}

}  // namespace

std::optional<double> shortest_path(const StaticMap& map, const Footprint& footprint,
                                    const Pose2& start, const Goal& goal) {
  const auto place = place_of(goal);
  if (!place) return std::nullopt;
  for (double radius = inner_radius(footprint); radius > 0.0; radius -= kThinner) {
    const Points way = find_path(map, start.position(), *place, radius, 0.0);
    if (!way.empty()) return length_to(goal, pulled_taut(map, way, radius));
  }
  return std::nullopt;
}

MetricsSetting metrics_setting(const Scenario& scenario, const System& system,
                               std::optional<double> shortest_path) {
  const auto robot = parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim").robot;
  const auto planner = parameters_of<LocalPlannerNodeParams>(system, "local_planner");
  return {.goal = scenario.goal,
          .v_max = robot.v_max,
          .w_max = robot.w_max,
          .after = scenario.after,
          .p_BA = scenario.p_BA,
          .shortest_path = shortest_path,
          .control_period = planner.live.nmpc.control_period};
}

}  // namespace tandem
