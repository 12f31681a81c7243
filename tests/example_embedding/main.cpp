// SPDX-License-Identifier: Apache-2.0
// Drives a robot through a map in a plain C++ program: a constant command of a person goes through
// the planner and the safety filter, and the robot moves as commanded. Prints one line per cycle.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include <tandem/local_planner/nmpc.hpp>
#include <tandem/map/map_file.hpp>
#include <tandem/map/slice.hpp>
#include <tandem/map/static_map.hpp>
#include <tandem/model/se2.hpp>
#include <tandem/obstacle_extractor/extractor.hpp>
#include <tandem/safety_filter/safety_filter.hpp>

int main(int argc, char** argv) try {
  if (argc != 5) return std::fprintf(stderr, "usage: avoid MAP X Y THETA\n"), 2;
  const auto tree = tandem::load_map(argv[1]);
  const auto map = std::make_shared<const tandem::StaticMap>(tandem::slice(*tree, {}));

  const tandem::RobotParams robot;  // the outline of a MiR 100, defaults for the rest
  const auto outline = tandem::footprint_of(robot);
  tandem::NmpcParams planning;
  planning.time_budget = 0.0;  // iterations, not time, limit a solve: the same drive on any machine
  tandem::Nmpc planner{planning, robot};
  tandem::Extractor extractor{map, {}};
  tandem::SafetyFilter filter{{}, robot};
  filter.on_map(map);

  const tandem::Twist2 person{0.6, 0.0};  // straight ahead at 0.6 m/s
  tandem::RobotState state;
  state.X_MB = {std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4])};
  const double period = planning.control_period;
  for (int cycle = 0; cycle < 200; ++cycle) {
    state.t = cycle * period;
    const auto obstacles = extractor.near(state.X_MB.position());
    tandem::PlanRequest request;
    request.method = tandem::Method::kIntention;
    request.t = state.t;
    request.X_MB = state.X_MB;
    request.command = request.measured = state.twist;
    request.user = person;
    request.obstacles = obstacles;
    request.guarded = true;
    const tandem::Plan plan = planner.solve(request);

    filter.on_command(plan.command, state.t);
    const tandem::Filtered out = filter.update(state, state.t);
    state.twist = out.twist;
    state.X_MB = tandem::integrate(state.X_MB, out.twist, period);
    std::printf(
        "%5.2f s  pose %6.2f %6.2f %6.2f  command %5.2f m/s %5.2f rad/s  clearance %.2f m\n",
        state.t, state.X_MB.x, state.X_MB.y, state.X_MB.theta, out.twist.v, out.twist.w,
        map->clearance(outline, state.X_MB, 1.0));
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "avoid: %s\n", error.what());
  return 1;
}
