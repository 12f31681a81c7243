// SPDX-License-Identifier: Apache-2.0
// A map of a million leaves arrives while the robot drives. Decoding it takes a while; neither the
// planner nor the safety filter waits for that.
#include <cstdio>
#include <random>
#include <set>
#include <string>

#include "map/octomap_file.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

constexpr int kLeaves = 1000000;
constexpr double kRate = 20.0;  // [1/s] of the planner and of the filter, at least

using octomap_msgs::msg::Octomap;

// The forest, and far from it a cloud of voxels that no pruning makes smaller.
Octomap large_map() {
  const auto tree = load_octomap(TANDEM_SOURCE_DIR "/maps/forest.bt");
  std::mt19937 random{1};
  std::uniform_real_distribution<float> place{20.0F, 40.0F};
  for (int i = 0; i < kLeaves; ++i)
    tree->updateNode(octomap::point3d{place(random), place(random), place(random)}, true, true);
  tree->updateInnerOccupancy();
  Octomap msg;
  msg.header().frame_id("map");
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(tree->getResolution());
  msg.data(encode_octomap(*tree));
  return msg;
}

TEST(LargeMap, IsDecodedWhileTheLoopsGoOn) {
  const Octomap map = large_map();
  SystemUnderTest system;
  std::set<std::string> taken;  // by whom
  const auto rosout = system.node().create_subscription(
      rt::Topic<rcl_interfaces::msg::Log>{"/rosout", rt::kDefault}, [&](const auto& msg) {
        if (msg.msg().starts_with("map: ")) taken.insert(msg.name());
      });
  long plans = 0;
  unsigned long overruns = 0;
  const auto status =
      system.node().create_subscription(topics::planner_status, [&](const auto& msg) {
        ++plans;
        overruns = msg.overruns();
      });
  const auto publisher = system.node().create_publisher(topics::octomap_binary);
  system.start_all();
  ASSERT_TRUE(system.wait_until([&] { return publisher.matched() >= 2; }, 10.0));
  ASSERT_TRUE(system.wait_until_driving());

  taken.clear();
  const double sent = system.sim_time;
  const long commands_before = system.commands, plans_before = plans;
  const unsigned long overruns_before = overruns;
  publisher.publish(map);
  ASSERT_TRUE(system.wait_until(
      [&] { return taken.contains("safety_filter") && taken.contains("obstacle_extractor"); },
      60.0));
  const double took = system.sim_time - sent;
  const double commands = static_cast<double>(system.commands - commands_before);
  const double planned = static_cast<double>(plans - plans_before);
  std::printf("%zu bytes taken after %.2f s: %.0f commands, %.0f plans, %lu overruns\n",
              map.data().size(), took, commands, planned, overruns - overruns_before);
  EXPECT_GT(took, 5.0 / kRate) << "no time to see anything in";
  // A loop that waited would beat once or twice; one on a busy machine misses some beats.
  EXPECT_GE(commands, 0.5 * kRate * took);
  EXPECT_GE(planned, 0.3 * kRate * took);
  EXPECT_EQ(system.collisions, 0U);
  EXPECT_TRUE(system.wait_until_driving()) << "does not drive on";
}

}  // namespace
}  // namespace tandem::test
