// SPDX-License-Identifier: Apache-2.0
// Prints the time of one call of the safety filter, far from and near to obstacles, and of one
// simulator step.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>

#include "tandem/diff_drive_sim/diff_drive_sim.hpp"
#include "tandem/safety_filter/safety_filter.hpp"

namespace tandem {
namespace {

// Corridor along x, its walls at |y| = half_width.
std::shared_ptr<const StaticMap> corridor(double half_width) {
  Grid grid;
  grid.width = grid.height = 400;
  grid.origin = {-10.0, -10.0};
  grid.cells.assign(400 * 400, Cell::kFree);
  for (int iy = 0; iy < 400; ++iy)
    for (int ix = 0; ix < 400; ++ix) {
      const Eigen::Vector2d p = grid.center(ix, iy);
      const bool wall = std::abs(std::abs(p.y()) - half_width - 0.1) < 0.1;
      if (wall)
        grid.cells[static_cast<std::size_t>(iy) * 400 + static_cast<std::size_t>(ix)] =
            Cell::kOccupied;
    }
  return std::make_shared<const StaticMap>(std::move(grid));
}

void filter_call(benchmark::State& state, double half_width, double y, const Twist2& command) {
  SafetyFilter filter({}, {});
  filter.on_map(corridor(half_width));
  const Twist2 measured{0.9 * command.v, 0.9 * command.w};
  double now = 0.0;
  double scale = 0.0;
  for (auto _ : state) {
    now += 0.05;
    filter.on_command(command, now);
    const Filtered out = filter.update(RobotState{{0.0, y, 0.02}, measured, now}, now);
    benchmark::DoNotOptimize(out);
    scale = out.scale;
  }
  state.counters["scale"] = scale;
}

void simulator_step(benchmark::State& state, double half_width) {
  DiffDriveSim sim({}, {}, corridor(half_width), 1);
  double t = 0.0;
  for (auto _ : state) {
    if (std::abs(sim.state().X_MB.x) > 8.0) sim.reset({}, 1);
    sim.command({0.5, 0.0}, t);
    t += 0.005;
    sim.advance_to(t);
  }
}

BENCHMARK_CAPTURE(filter_call, far_from_everything, 5.0, 0.0, Twist2{0.8, 0.2});
BENCHMARK_CAPTURE(filter_call, in_a_corridor_1_6_m_wide, 0.8, 0.0, Twist2{0.8, 0.05});
BENCHMARK_CAPTURE(filter_call, in_a_corridor_1_0_m_wide, 0.5, 0.0, Twist2{0.5, 0.05});
BENCHMARK_CAPTURE(filter_call, slowed_beside_a_wall, 0.8, 0.4, Twist2{0.8, 0.5});
BENCHMARK_CAPTURE(filter_call, blocked_beside_a_wall, 0.8, 0.48, Twist2{0.8, 1.0});
BENCHMARK_CAPTURE(filter_call, within_the_margin_of_a_wall, 0.8, 0.5, Twist2{0.3, -0.5});
BENCHMARK_CAPTURE(simulator_step, free, 5.0);
BENCHMARK_CAPTURE(simulator_step, in_a_corridor_1_0_m_wide, 0.5);

}  // namespace
}  // namespace tandem

BENCHMARK_MAIN();
