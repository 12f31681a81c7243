// SPDX-License-Identifier: Apache-2.0
// Prints what a look at the map and an update of the obstacles cost.
#include <benchmark/benchmark.h>

#include <random>

#include "../obstacle_extractor/worlds.hpp"
#include "model/footprint.hpp"
#include "obstacle_extractor/extractor.hpp"

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

void first_update(benchmark::State& state, const World& world) {
  const auto all = poses(world->grid());
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(extract(*world, all[++i % all.size()].position(), {}).size());
}

void next_update(benchmark::State& state, const World& world) {
  const auto all = poses(world->grid());
  Extractor extractor(world, {});
  for (const Pose2& X : all) (void)extractor.near(X.position());
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(extractor.near(all[++i % all.size()].position()).size());
}

void add(const std::string& name, const World& world) {
  benchmark::RegisterBenchmark((name + "/distance").c_str(), distance, world);
  for (const double cap : {0.05, 0.3, 1.0})
    benchmark::RegisterBenchmark((name + "/clearance, cap " + std::to_string(cap)).c_str(),
                                 clearance, world, cap);
  benchmark::RegisterBenchmark((name + "/distance field").c_str(), field, world)
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark((name + "/first update").c_str(), first_update, world)
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark((name + "/next update").c_str(), next_update, world)
      ->Unit(benchmark::kMicrosecond);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  tandem::add("forest", tandem::forest());
  tandem::add("building", tandem::building());
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
