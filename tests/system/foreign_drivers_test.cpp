// SPDX-License-Identifier: Apache-2.0
// Tests third-party drivers, localisers and map servers, which offer weaker QoS than Tandem's
// nodes.
#include <optional>
#include <utility>
#include <vector>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

class ForeignDrivers : public OneComponent {
 protected:
  // True if a best-effort publisher, the weakest offer, is received.
  template <class M>
  [[nodiscard]] bool hears_best_effort(const rt::Topic<M>& topic) {
    int heard = 0;
    const auto subscription = node_.create_subscription(topic, [&](const auto&) { ++heard; });
    const auto driver = other_.create_publisher(topic, rt::kBestEffort(1));
    return spin_until(
        [&] {
          driver.publish({});
          return heard > 0;
        },
        kTimeout, node_, other_);
  }

  rt::Node other_{"driver_of_another_make"};
};

TEST_F(ForeignDrivers, AreReceivedAlthoughTheyOfferBestEffortAndVolatile) {
  EXPECT_TRUE(hears_best_effort(topics::odom));
  EXPECT_TRUE(hears_best_effort(topics::tf));
  EXPECT_TRUE(hears_best_effort(topics::tf_static));
  EXPECT_TRUE(hears_best_effort(topics::scan));
  EXPECT_TRUE(hears_best_effort(topics::cloud_in));
  EXPECT_TRUE(hears_best_effort(topics::people));
  EXPECT_TRUE(hears_best_effort(topics::octomap_binary));
  EXPECT_TRUE(hears_best_effort(topics::map));
  EXPECT_TRUE(hears_best_effort(topics::goal_pose));
  EXPECT_TRUE(hears_best_effort(topics::initial_pose));
}

// A TurtleBot 4 publishes odometry best effort; octomap_server with `latch: false` publishes a
// volatile map.
TEST_F(ForeignDrivers, DriveARobotWithVolatileMapAndBestEffortOdometry) {
  ChildProcess robot{"../tandem",
                     {"run", source_path("bringup/systems/teleop.yaml"), "--ros-args", "-p",
                      "arbitration:policy:=manual", "-p", "dashboard:port:=0", "-p",
                      "diff_drive_sim:qos_overrides./odom.publisher.reliability:=best_effort", "-p",
                      "diff_drive_sim:qos_overrides./tf.publisher.reliability:=best_effort", "-r",
                      "map_server:octomap_binary:=/stored_map"}};
  std::optional<octomap_msgs::msg::Octomap> map;
  const auto stored =
      node_.create_subscription(rt::Topic<octomap_msgs::msg::Octomap>{"/stored_map", rt::kLatched},
                                [&](const auto& msg) { map = msg; });
  const auto octomap_server = node_.create_publisher(topics::octomap_binary, rt::kDefault);
  const auto again = node_.create_wall_timer(1.0, [&] {
    if (map) octomap_server.publish(*map);
  });
  const auto user = node_.create_publisher(rt::Topic<geometry_msgs::msg::Twist>{"/cmd_vel_user"});
  const auto beat = node_.create_wall_timer(0.05, [&] { user.publish(to_msg(Twist2{0.3, 0.0})); });
  std::optional<Pose2> start, now;
  const auto truth = node_.create_subscription(topics::ground_truth, [&](const auto& msg) {
    now = from_msg(msg).value_or(Odometry{}).X;
    if (!start) start = now;
  });
  EXPECT_TRUE(
      spin_until([&] { return start && (now->position() - start->position()).norm() > kTravelled; },
                 kLongTimeout, node_));
}

}  // namespace
}  // namespace tandem::test
