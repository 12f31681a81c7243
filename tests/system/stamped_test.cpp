// SPDX-License-Identifier: Apache-2.0
// Tests the whole loop with TwistStamped at both ends: the person's commands and the robot's
// commands.
#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

TEST(StampedCommands, DriveTheRobotAndReachIt) {
  ChildProcess robot{"../tandem",
                     {"run", source_path("bringup/systems/teleop.yaml"), "--ros-args", "-p",
                      "arbitration:policy:=manual", "-p", "safety_filter:stamped:=true"}};
  rt::Node node{"tester"};
  const auto user =
      node.create_publisher(rt::Topic<geometry_msgs::msg::TwistStamped>{"/cmd_vel_user"});
  const auto beat = node.create_wall_timer(0.05, [&] {
    geometry_msgs::msg::TwistStamped msg;  // a stamp of zero: none
    msg.twist(to_msg(Twist2{0.3, 0.0}));
    user.publish(msg);
  });
  geometry_msgs::msg::TwistStamped told;
  const auto cmd_vel =
      node.create_subscription(topics::cmd_vel_stamped, [&](const auto& msg) { told = msg; });
  std::optional<Pose2> start, now;
  const auto truth = node.create_subscription(topics::ground_truth, [&](const auto& msg) {
    now = from_msg(msg).value_or(Odometry{}).X;
    if (!start) start = now;
  });
  ASSERT_TRUE(
      spin_until([&] { return start && (now->position() - start->position()).norm() > kTravelled; },
                 kLongTimeout, node));
  EXPECT_TRUE(
      spin_until([&] { return is_near(told.twist().linear().x(), 0.3); }, kLongTimeout, node));
  EXPECT_EQ(told.header().frame_id(), "base_link");
  EXPECT_GT(rt::to_seconds(told.header().stamp()), 0.0);
}

}  // namespace
}  // namespace tandem::test
