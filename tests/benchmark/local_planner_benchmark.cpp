// SPDX-License-Identifier: Apache-2.0
// Prints the time of warm solves per method and number of obstacles, then percentiles of whole
// closed loops.
#include <benchmark/benchmark.h>

#include <cstdio>

#include "local_planner/drive.hpp"

namespace tandem::test {
namespace {

constexpr Method kMethods[] = {Method::kLeader, Method::kIntention, Method::kGoal};

// `count` poles on both sides of the path, near enough to matter.
std::vector<Obstacle> alley(int count) {
  std::vector<Obstacle> poles;
  for (int i = 0; i < count; ++i)
    poles.push_back({static_cast<std::uint32_t>(i + 1),
                     {0.6 + 0.5 * (i / 2), i % 2 == 0 ? 0.75 : -0.75},
                     0.225,
                     0.15,
                     0.4 * i,
                     {0, 0}});
  return poles;
}

// Runs consecutive cycles of a robot that drives down the alley, and restarts at its end.
void warm_solve(benchmark::State& state) {
  const auto method = kMethods[state.range(0)];
  const auto obstacles = alley(static_cast<int>(state.range(1)));
  NmpcParams params;
  params.time_budget = 0.0;
  Nmpc planner(params, RobotParams{});
  PlanRequest request{.method = method, .user = {0.6, 0.0}};
  double iterations = 0.0;
  for (auto _ : state) {
    request.obstacles = obstacles;
    request.X_MG = {method == Method::kLeader ? request.X_MB.x + 1.2 : 5.0, 0.0, 0.0};
    const Plan plan = planner.solve(request);
    iterations += plan.iterations;
    request.t += params.control_period;
    request.X_MB = integrate(request.X_MB, plan.command, params.control_period);
    request.command = request.measured = plan.command;
    if (request.X_MB.x < 3.0) continue;
    state.PauseTiming();
    request.X_MB = {};
    request.command = request.measured = {};
    (void)planner.solve(request);
    state.ResumeTiming();
  }
  state.counters["iterations"] = benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
  state.SetLabel(name(method));
}
BENCHMARK(warm_solve)->ArgsProduct({{0, 1, 2}, {0, 2, 8, 16}})->Unit(benchmark::kMillisecond);

void print_closed_loops() {
  const std::vector<Eigen::Vector2d> way{{-3, -3.4},  {-2.6, -2.9}, {0, -2.2},
                                         {2.2, -1.8}, {2.2, 0.5},   {4, 2.5}};
  std::printf("\nforest with walls, 30 s at 20 Hz, budget 35 ms\n");
  std::printf("%-10s %7s %7s %7s %7s ms  fallbacks contacts\n", "method", "p50", "p95", "p99",
              "max");
  for (const Method method : kMethods) {
    const Person leader = leader_along(way, 0.72, 1.2);
    const Person person = [&](double t, const Plant& plant, PlanRequest& request) {
      leader(t, plant, request);
      request.method = method;
      if (method == Method::kGoal) request.X_MG = {4.0, 2.5, 0.0};
      const double bearing =
          std::atan2(request.X_MG.y - plant.X_MB.y, request.X_MG.x - plant.X_MB.x);
      request.user = {0.6, std::clamp(wrap_angle(bearing - plant.X_MB.theta), -0.8, 0.8)};
    };
    const Drive result = drive(NmpcParams{}, RobotParams{}, {{-4, -4, 0}, {}, 0.02, 0.05},
                               forest(true), 30.0, person);
    std::printf("%-10s %7.2f %7.2f %7.2f %7.2f     %9d %8d\n", name(method),
                1e3 * result.percentile(0.5), 1e3 * result.percentile(0.95),
                1e3 * result.percentile(0.99), 1e3 * result.percentile(1.0), result.fallbacks,
                result.contacts);
  }
}

}  // namespace
}  // namespace tandem::test

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  tandem::test::print_closed_loops();
}
