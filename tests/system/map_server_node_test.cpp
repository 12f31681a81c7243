// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/slice.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

const std::string kForest = source_path("maps/forest.bt");

class MapServerOverDds : public OneComponent {
 protected:
  MapServerOverDds() { fs::create_directories(folder_); }
  ~MapServerOverDds() override { fs::remove_all(folder_); }

  fs::path folder_ = fs::temp_directory_path() / ("tandem_map_server_" + std::to_string(getpid()));
};

TEST_F(MapServerOverDds, GivesALateJoinerBothMaps) {
  const CapturedLog log;
  const auto server = load("map_server", {{"map", kForest}});
  ASSERT_TRUE(wait_until([&] { return log.lines("serving " + kForest) == 1; }));  // all published
  octomap_msgs::msg::Octomap octomap;
  nav_msgs::msg::OccupancyGrid grid;
  const auto octomap_in =
      node_.create_subscription(topics::octomap_binary, [&](const auto& msg) { octomap = msg; });
  const auto grid_in = node_.create_subscription(topics::map, [&](const auto& msg) { grid = msg; });
  ASSERT_TRUE(wait_until([&] { return !octomap.data().empty() && !grid.data().empty(); }));

  const auto tree = load_octomap(kForest);
  EXPECT_EQ(octomap.header().frame_id(), "map");
  EXPECT_EQ(octomap.id(), "OcTree");
  EXPECT_TRUE(octomap.binary());
  EXPECT_EQ(octomap.resolution(), tree->getResolution());
  EXPECT_EQ(octomap.data(), encode_octomap(*tree));

  const Grid expected = slice(*tree, {});
  EXPECT_EQ(grid.header().frame_id(), "map");
  EXPECT_EQ(grid.info().width(), static_cast<unsigned>(expected.width));
  EXPECT_EQ(grid.info().height(), static_cast<unsigned>(expected.height));
  EXPECT_NEAR(grid.info().resolution(), expected.resolution, 1e-6);
  EXPECT_NEAR(grid.info().origin().position().x(), expected.origin.x(), 1e-9);
  EXPECT_EQ(std::count(grid.data().begin(), grid.data().end(), 100),
            std::count(expected.cells.begin(), expected.cells.end(), Cell::kOccupied));
}

TEST_F(MapServerOverDds, StampsBothMapsWithTheTimeOfTheStart) {
  const auto server = load("map_server", {{"map", kForest}});
  octomap_msgs::msg::Octomap octomap;
  nav_msgs::msg::OccupancyGrid grid;
  const auto octomap_in =
      node_.create_subscription(topics::octomap_binary, [&](const auto& msg) { octomap = msg; });
  const auto grid_in = node_.create_subscription(topics::map, [&](const auto& msg) { grid = msg; });
  ASSERT_TRUE(wait_until([&] { return !octomap.data().empty() && !grid.data().empty(); }));
  EXPECT_NEAR(rt::to_seconds(grid.header().stamp()), rt::to_seconds(node_.stamp()), 60.0);
  EXPECT_EQ(grid.info().map_load_time(), grid.header().stamp());
  EXPECT_EQ(octomap.header().stamp(), grid.header().stamp());
}

TEST_F(MapServerOverDds, WaitsForTheTimeOfASimulation) {
  const auto server = load("map_server", {{"map", kForest}, {"use_sim_time", "true"}});
  const auto clock = node_.create_publisher(topics::clock);
  nav_msgs::msg::OccupancyGrid grid;
  const auto grid_in = node_.create_subscription(topics::map, [&](const auto& msg) { grid = msg; });
  ASSERT_TRUE(wait_until([&] { return clock.matched() >= 1 && grid_in.matched() == 1; }));
  EXPECT_TRUE(grid.data().empty());
  rosgraph_msgs::msg::Clock time;
  time.clock(rt::to_stamp(7'250'000'000));
  ASSERT_TRUE(wait_until([&] {
    clock.publish(time);
    return !grid.data().empty();
  }));
  EXPECT_EQ(rt::to_seconds(grid.header().stamp()), 7.25);
  EXPECT_EQ(grid.info().map_load_time(), grid.header().stamp());
}

TEST_F(MapServerOverDds, ServesAMapOfNav2s) {
  std::ofstream{folder_ / "room.pgm"} << "P2 2 2 255 0 205 254 254";
  std::ofstream{folder_ / "room.yaml"} << "image: room.pgm\nresolution: 0.5\norigin: [1, -2, 0]\n"
                                          "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.19\n";
  const auto server = load("map_server", {{"map", folder_ / "room.yaml"}});
  octomap_msgs::msg::Octomap octomap;
  nav_msgs::msg::OccupancyGrid grid;
  const auto octomap_in =
      node_.create_subscription(topics::octomap_binary, [&](const auto& msg) { octomap = msg; });
  const auto grid_in = node_.create_subscription(topics::map, [&](const auto& msg) { grid = msg; });
  ASSERT_TRUE(wait_until([&] { return !octomap.data().empty() && !grid.data().empty(); }));
  EXPECT_EQ(grid.data(), (std::vector<std::int8_t>{0, 0, 100, -1}));
  EXPECT_NEAR(grid.info().origin().position().x(), 1.0, 1e-9);
  const auto decoded =
      decode_octomap({octomap.id(), octomap.binary(), octomap.resolution()}, octomap.data());
  ASSERT_TRUE(decoded.tree) << decoded.error;
  EXPECT_TRUE(decoded.tree->isNodeOccupied(decoded.tree->search(1.25, -1.25, 0.25)));
}

TEST_F(MapServerOverDds, ABrokenFileEndsTheProgramWithOneLineThatNamesIt) {
  const std::string broken = (folder_ / "broken.bt").string();
  std::ifstream in{kForest, std::ios::binary};
  const std::string bytes{std::istreambuf_iterator<char>{in}, {}};
  std::ofstream{broken, std::ios::binary} << bytes.substr(0, bytes.size() / 2);
  const fs::path system = folder_ / "system.yaml";
  std::ofstream{system} << "components:\n  - {component: map_server, parameters: {map: " << broken
                        << "}}\n";
  const CapturedLog log;
  ChildProcess program{"../tandem", {"run", system.string()}};
  EXPECT_EQ(program.wait(20.0), 1);
  EXPECT_EQ(log.text(), "tandem: " + system.string() + ": map_server: " + broken +
                            ": truncated or damaged (its tree does not end where the header says); "
                            "copy it again or rebuild the map\n");
}

TEST_F(OneComponent, AMapThatIsMissingStopsTheStart) {
  EXPECT_THROW(
      (void)rt::load_component("map_server", options("map_server", {{"map", "/no/such.bt"}})),
      std::runtime_error);
}

}  // namespace
}  // namespace tandem::test
