// SPDX-License-Identifier: Apache-2.0
// A map of two million leaves arrives while the robot drives. Decoding it takes time, and neither
// the planner nor the safety filter may wait for it.
#include <algorithm>
#include <cstdio>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/paths.hpp"
#include "system/system_under_test.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem::test {
namespace {

constexpr int kLeaves = 2000000;
constexpr double kRate = 20.0;             // [1/s] minimum rate of the planner and of the filter
constexpr double kBaseStops = 0.1;         // [s] without a command: base_timeout of mir100.yaml
constexpr double kPlannerIsSilent = 0.12;  // [s] without a plan: shared_timeout of arbitration
constexpr double kUndisturbed = 2.0;       // [s] before the map comes

using octomap_msgs::msg::Octomap;

// The forest and, far from it, a cloud of voxels that pruning cannot reduce.
Octomap large_map() {
  const auto tree = load_octomap(source_path("maps/forest.bt"));
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

// Records a loop's cycles by the robot's clock, so that delays of the watcher do not count.
struct Beats {
  std::vector<double> times = {};

  void at(const std_msgs::msg::Header& header) { times.push_back(rt::to_seconds(header.stamp())); }
  /// The longest pause that ended within (from, to] [s].
  [[nodiscard]] double longest_pause(double from, double to) const {
    double longest = 0.0;
    for (std::size_t i = 1; i < times.size(); ++i)
      if (times[i] > from && times[i] <= to) longest = std::max(longest, times[i] - times[i - 1]);
    return longest;
  }
  [[nodiscard]] long between(double from, double to) const {
    return std::count_if(times.begin(), times.end(), [&](double t) { return t > from && t <= to; });
  }
};

// The loops' behaviour within (from, to] [s].
struct Seen {
  Seen(const Beats& all_commands, const Beats& all_plans, double from, double to,
       unsigned long late)
      : seconds{to - from},
        without_command{all_commands.longest_pause(from, to)},
        without_plan{all_plans.longest_pause(from, to)},
        commands{all_commands.between(from, to)},
        plans{all_plans.between(from, to)},
        overruns{late} {}

  void print(const char* when) const {
    std::printf("%s, %.2f s: %ld commands, longest pause %.3f s; %ld plans, %.3f s; %lu overruns\n",
                when, seconds, commands, without_command, plans, without_plan, overruns);
  }

  /// Of the plans.
  [[nodiscard]] double share_late() const {
    return static_cast<double>(overruns) / std::max(1.0, static_cast<double>(plans));
  }

  double seconds, without_command, without_plan;
  long commands, plans;
  unsigned long overruns;
};

TEST(LargeMap, IsDecodedWhileTheLoopsGoOn) {
  const Octomap map = large_map();
  SystemUnderTest system;
  std::set<std::string> taken;  // names of the nodes that loaded the map
  const auto rosout = system.node().create_subscription(
      rt::Topic<rcl_interfaces::msg::Log>{"/rosout", rt::kDefault}, [&](const auto& msg) {
        if (msg.msg().starts_with("map: ")) taken.insert(msg.name());
      });
  Beats plans, commands;
  unsigned long overruns = 0, cycles = 0;
  const auto planner =
      system.node().create_subscription(topics::planner_status, [&](const auto& msg) {
        if (std::exchange(cycles, msg.cycles()) != msg.cycles()) plans.at(msg.header());
        overruns = msg.overruns();
      });
  const auto filter = system.node().create_subscription(
      topics::filter_status, [&](const auto& msg) { commands.at(msg.header()); });
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  // From now on the only map publisher: with two, neither map would be accepted.
  system.process("map_server").send(SIGTERM);
  ASSERT_TRUE(system.process("map_server").wait(10.0));
  const auto publisher = system.node().create_publisher(topics::octomap_binary);
  ASSERT_TRUE(system.wait_until([&] { return publisher.matched() >= 2; }, 10.0));
  const double before = system.sim_time;
  const unsigned long overruns_before = overruns;
  ASSERT_TRUE(system.wait_until([&] { return system.sim_time > before + kUndisturbed; }, 20.0));

  taken.clear();
  const double sent = system.sim_time;
  const unsigned long overruns_sent = overruns;
  publisher.publish(map);
  ASSERT_TRUE(system.wait_until(
      [&] { return taken.contains("safety_filter") && taken.contains("obstacle_extractor"); },
      60.0));
  const double end = system.sim_time, took = end - sent;
  const Seen calm{commands, plans, before, sent, overruns_sent - overruns_before};
  const Seen busy{commands, plans, sent, end, overruns - overruns_sent};
  std::printf("%zu bytes\n", map.data().size());
  calm.print("before");
  busy.print("while it is decoded");
  EXPECT_GT(took, 5.0 / kRate) << "no time to see anything in";
  EXPECT_GE(static_cast<double>(busy.commands), 0.5 * kRate * took);
  EXPECT_GE(static_cast<double>(busy.plans), 0.3 * kRate * took);
  // On an equally busy machine, the map must not cause additional missed deadlines.
  EXPECT_LT(busy.without_command, std::max(kBaseStops, 2.0 * calm.without_command));
  EXPECT_LT(busy.without_plan, std::max(kPlannerIsSilent, 2.0 * calm.without_plan));
  EXPECT_LE(busy.share_late(), calm.share_late() + 0.1);
  EXPECT_EQ(system.collisions, 0U);
  EXPECT_TRUE(system.wait_until_driving()) << "does not drive on";
}

}  // namespace
}  // namespace tandem::test
