// SPDX-License-Identifier: Apache-2.0
// Runs arbitration and other components in one process, and checks the reasons that arbitration
// gives.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "support/captured_log.hpp"
#include "system/one_component.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/model/reasons.hpp"

namespace tandem::test {
// Free ground about the robot, and a wall across its way if wanted.
inline octomap_msgs::msg::Octomap map_with_wall(double wall) {
  octomap::OcTree tree(0.05);
  for (int i = -80; i <= 80; ++i) {
    for (int k = -80; k <= 80; ++k)
      tree.updateNode(octomap::point3d(0.05F * static_cast<float>(i) + 0.02F,
                                       0.05F * static_cast<float>(k) + 0.02F, 0.3F),
                      false);
    tree.updateNode(
        octomap::point3d(static_cast<float>(wall), 0.05F * static_cast<float>(i) + 0.02F, 0.3F),
        true);
  }
  octomap_msgs::msg::Octomap msg;
  msg.header(header({}, "map"));
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(0.05);
  msg.data(encode_octomap(tree));
  return msg;
}

// Returns 3 m away all around.
inline sensor_msgs::msg::LaserScan round_scan() {
  sensor_msgs::msg::LaserScan scan;
  scan.header().frame_id("laser");
  scan.angle_min(-3.1F);
  scan.angle_increment(0.0172F);
  scan.angle_max(3.1F);
  scan.range_min(0.1F);
  scan.range_max(10.0F);
  scan.ranges().assign(360, 3.0F);
  return scan;
}

// Runs arbitration; the test publishes what base, localiser, joystick and map_server would.
class Sweep : public OneComponent {
 protected:
  Sweep() {
    status_ = node_.create_subscription(topics::arbitration_status, [this](const auto& msg) {
      words_ = msg.reason();
      reason_ = from_msg(msg.reason_code());
      remedy_ = msg.remedy();
      EXPECT_FALSE(words_.starts_with("arbitration: ")) << words_;  // itself, by a circle
    });
    beat_ = node_.create_wall_timer(0.02, [this] { beat(); });
  }

  void beat() {
    if (odom_on_) {
      auto msg = to_msg(Odometry{X_WB_, twist_}, header(node_.stamp(), "odom"), "base_link");
      odom_.publish(msg);
    }
    // A person lets go where the stick must be seen at rest: after a stall of this process.
    if (pushes_) hold(reason_ == Reason::kStickMoved ? 0.0F : 0.5F);
    if (joy_on_) joy_.publish(stick_);
    if (local_on_) local_.publish(local_map_);
  }
  void run(const std::string& component, Values values = {},
           const std::map<std::string, std::string>& remappings = {}) {
    if (component != "arbitration") values.emplace("map_is_odom", "true");
    values.merge(patience(component));
    rt::NodeOptions node = options(component, values);
    node.remappings = remappings;
    running_[component] =
        std::make_unique<rt::RunningComponent>(rt::load_component(component, node));
  }
  // Time-outs that a busy computer keeps: what is silent for a moment would be one more reason.
  static Values patience(const std::string& component) {
    if (component == "arbitration") return {{"user_timeout", "1.0"}, {"shared_timeout", "1.0"}};
    if (component == "teleop") return {{"joy_timeout", "1.0"}};
    if (component == "local_planner") return {{"user_timeout", "1.0"}, {"obstacle_timeout", "1.0"}};
    return {};
  }
  void end(const std::string& component) { running_.erase(component); }
  void hold(float linear, int deadman = 1) {
    stick_.axes({0.0F, linear});
    stick_.buttons({deadman, 0});
    joy_on_ = true;
  }
  // A stick that was seen at rest, pushed.
  void push() {
    hold(0.0F);
    const auto user =
        node_.create_subscription(topics::cmd_vel_user, [this](const auto&) { ++user_; });
    EXPECT_TRUE(wait_until([this] { return user_ > 0; }));
    pushes_ = true;
  }

  // It is published with its remedy and number, and logged once more than before, with the remedy.
  void expect_reason(const std::string& begin, Reason row) {
    EXPECT_TRUE(wait_until([&] { return words_.starts_with(begin); }))
        << "expected " << begin << ", not " << words_;
    EXPECT_EQ(reason_, row) << words_;
    EXPECT_EQ(remedy_, words(row).remedy) << words_;
    EXPECT_FALSE(remedy_.empty()) << words_;
    EXPECT_TRUE(wait_until([&] { return lines_of_arbitration(begin) > 0; })) << begin;
    EXPECT_EQ(lines_of_arbitration(begin), 1) << begin;
    EXPECT_GT(log_.lines(words(row).remedy), 0) << begin;
  }
  [[nodiscard]] int lines_of_arbitration(const std::string& begin) const {
    int count = 0;
    for (const char* source : {"none", "user", "shared", "blend", "nav"})
      count += log_.lines("[arbitration]: " + std::string{source} + ": " + begin);
    return count;
  }

  CapturedLog log_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<sensor_msgs::msg::Joy> joy_ = node_.create_publisher(topics::joy);
  rt::Publisher<octomap_msgs::msg::Octomap> map_ = node_.create_publisher(topics::octomap_binary);
  rt::Publisher<octomap_msgs::msg::Octomap> local_ = node_.create_publisher(topics::octomap_local);
  rt::Subscription status_;
  rt::Timer beat_;
  std::map<std::string, std::unique_ptr<rt::RunningComponent>> running_;
  Pose2 X_WB_;
  Twist2 twist_;
  sensor_msgs::msg::Joy stick_;
  octomap_msgs::msg::Octomap local_map_ = map_with_wall(3.0);
  bool odom_on_ = true, joy_on_ = false, local_on_ = false, pushes_ = false;
  int user_ = 0;  ///< commands of teleop
  Reason reason_ = Reason::kNone;
  std::string words_, remedy_;
};

}  // namespace tandem::test
