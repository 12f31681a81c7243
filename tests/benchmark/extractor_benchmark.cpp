// SPDX-License-Identifier: Apache-2.0
// Prints what a look at the map and an update of the obstacles cost.
#include <benchmark/benchmark.h>

#include <random>
#include <thread>

#include "../obstacle_extractor/worlds.hpp"
#include "model/footprint.hpp"
#include "obstacle_extractor/shapes_ahead.hpp"

namespace tandem {
namespace {

using World = std::shared_ptr<const StaticMap>;

const World& forest() {
  static const World world = test::load_world(test::project_map("forest"));
  return world;
}

const World& building() {
  static const World world = std::filesystem::exists(test::building_map())
                                 ? test::load_world(test::building_map())
                                 : test::load_world(test::project_map("corridor"));
  return world;
}

std::vector<Pose2> poses(const Grid& grid) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> angle(-3.0, 3.0);
  std::vector<Pose2> all;
  for (int i = 0; i < 4096; ++i) {
    const Eigen::Vector2d p = test::random_point(random, grid);
    all.push_back({p.x(), p.y(), angle(random)});
  }
  return all;
}

void distance(benchmark::State& state, const World& world) {
  const auto all = poses(world->grid());
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(world->distance(all[++i % all.size()].position()));
}

void clearance(benchmark::State& state, const World& world, double cap) {
  const Footprint mir = rectangle(0.89, 0.58, 0.038);
  auto all = poses(world->grid());
  std::erase_if(all, [&](const Pose2& X) { return world->clearance(mir, X, 0.1) == 0.0; });
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(world->clearance(mir, all[++i % all.size()], cap));
}

void field(benchmark::State& state, const World& world) {
  for (auto _ : state) benchmark::DoNotOptimize(StaticMap(world->grid()).grid().width);
}

// The places a robot can be in, once per map; on the fitting thread.
void places(benchmark::State& state, const World& world) {
  for (auto _ : state) benchmark::DoNotOptimize(Places(*world, 0.42).radius());
}

// All tiles about a place, never seen before; on the fitting thread.
void first_look(benchmark::State& state, const World& world) {
  const auto all = poses(world->grid());
  std::size_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Extractor extractor(world, {});
    state.ResumeTiming();
    benchmark::DoNotOptimize(extractor.near(all[++i % all.size()].position()).size());
  }
}

// What the node does each period: positions about the middle of a window of 8 m x 8 m.
void update(benchmark::State& state, const World& world) {
  const Grid& grid = world->grid();
  const Eigen::Vector2d middle = grid.center(grid.width / 2, grid.height / 2);
  std::mt19937 random{1};
  std::uniform_real_distribution<double> metres(-0.6, 0.6);
  ShapesAhead shapes({});
  while (!shapes.near(world, middle)) std::this_thread::yield();
  for (auto _ : state) {
    const auto near = shapes.near(world, middle + Eigen::Vector2d{metres(random), metres(random)});
    if (!near) state.SkipWithError("not fitted");
    benchmark::DoNotOptimize(near->size());
  }
}

// The forest's cells again and again, the same about the middle, over `side` x `side` cells.
World forests(int side) {
  const Grid& one = forest()->grid();
  Grid grid = one;
  grid.width = grid.height = side;
  grid.cells.clear();
  const auto wrap = [](int i, int middle, int size) {
    return ((i - middle + size / 2) % size + size) % size;
  };
  for (int iy = 0; iy < side; ++iy)
    for (int ix = 0; ix < side; ++ix)
      grid.cells.push_back(one.at(wrap(ix, side / 2, one.width), wrap(iy, side / 2, one.height)));
  return std::make_shared<StaticMap>(std::move(grid));
}

void add(const std::string& name, const World& world) {
  benchmark::RegisterBenchmark((name + "/distance").c_str(), distance, world);
  for (const double cap : {0.05, 0.3, 1.0})
    benchmark::RegisterBenchmark((name + "/clearance, cap " + std::to_string(cap)).c_str(),
                                 clearance, world, cap);
  benchmark::RegisterBenchmark((name + "/distance field").c_str(), field, world)
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark((name + "/places").c_str(), places, world)
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark((name + "/first look").c_str(), first_look, world)
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark((name + "/update").c_str(), update, world)
      ->Unit(benchmark::kMicrosecond);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  tandem::add("forest", tandem::forest());
  tandem::add("building", tandem::building());
  for (const int side : {316, 3162})
    benchmark::RegisterBenchmark(
        ("forest of " + std::to_string(side * side) + " cells/update").c_str(), tandem::update,
        tandem::forests(side))
        ->Unit(benchmark::kMicrosecond);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
