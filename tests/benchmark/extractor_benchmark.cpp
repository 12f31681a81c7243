// SPDX-License-Identifier: Apache-2.0
// Prints the cost of reading the map and of updating the obstacles.
#include <benchmark/benchmark.h>

#include <random>
#include <thread>

#include "obstacle_extractor/worlds.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/model/footprint.hpp"
#include "tandem/obstacle_extractor/background_extractor.hpp"

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

// Finds the positions that a robot can be in, once per map; on the fitting thread.
void places(benchmark::State& state, const World& world) {
  for (auto _ : state) benchmark::DoNotOptimize(FreeRegions(*world, 0.42).radius());
}

// Fits all tiles around a new position; on the fitting thread.
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

// The node's work in each period: positions near the centre of a window of 8 m x 8 m.
void update(benchmark::State& state, const World& world) {
  const Eigen::Vector2d middle{0.0, 0.0};  // of the forest and its copies; free in the building too
  std::mt19937 random{1};
  std::uniform_real_distribution<double> metres(-0.6, 0.6);
  BackgroundExtractor shapes({}, [] {});
  while (!shapes.near(world, middle)) (void)shapes.work();
  for (auto _ : state) {
    const auto near = shapes.near(world, middle + Eigen::Vector2d{metres(random), metres(random)});
    if (!near) state.SkipWithError("not fitted");
    benchmark::DoNotOptimize(near->size());
  }
}

// The forest's occupied voxels in tiles x tiles copies, one of them at the forest's position.
octomap::OcTree forests(int tiles) {
  const auto one = load_octomap(test::project_map("forest"));
  octomap::OcTree all{one->getResolution()};
  constexpr int kTile = 204;  // cells from one copy to the next
  one->expand();
  for (auto leaf = one->begin_leafs(); leaf != one->end_leafs(); ++leaf) {
    if (!one->isNodeOccupied(*leaf)) continue;
    for (int iy = 0; iy < tiles; ++iy)
      for (int ix = 0; ix < tiles; ++ix) {
        octomap::OcTreeKey key = leaf.getKey();
        key[0] = static_cast<octomap::key_type>(key[0] + kTile * (ix - tiles / 2));
        key[1] = static_cast<octomap::key_type>(key[1] + kTile * (iy - tiles / 2));
        all.setNodeValue(key, all.getClampingThresMaxLog(), true);
      }
  }
  all.updateInnerOccupancy();
  return all;  // not pruned: as many leaves as voxels
}

// A message as map_server publishes it.
struct Message {
  std::vector<std::int8_t> data;
  double resolution, leaves;
};

Message message(int tiles) {
  const octomap::OcTree tree = forests(tiles);
  return {encode_octomap(tree), tree.getResolution(), static_cast<double>(tree.getNumLeafNodes())};
}

World decoded(const Message& msg) {
  const auto map = decode_octomap({.resolution = msg.resolution}, msg.data);
  return std::make_shared<const StaticMap>(slice(*map.tree, {}));
}

void decode(benchmark::State& state, const Message& msg) {
  for (auto _ : state) benchmark::DoNotOptimize(decoded(msg)->grid().width);
  state.counters["leaves"] = msg.leaves;
}

// The same window of 8 m x 8 m in a map of any size.
void add_map_of(int tiles) {
  const Message msg = message(tiles);
  const std::string name = "map of " + std::to_string(static_cast<long>(msg.leaves)) + " leaves";
  const World world = decoded(msg);
  benchmark::RegisterBenchmark((name + "/decode").c_str(), decode, msg)
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark((name + "/places").c_str(), places, world)
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark((name + "/update").c_str(), update, world)
      ->Unit(benchmark::kMicrosecond);
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
  for (const int tiles : {1, 13}) tandem::add_map_of(tiles);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
