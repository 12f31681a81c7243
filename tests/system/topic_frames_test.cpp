// SPDX-License-Identifier: Apache-2.0
// Tests which topics depend on the frame in their header.
#include <fstream>
#include <functional>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <vector>

#include "support/captured_log.hpp"
#include "support/paths.hpp"
#include "support/point_cloud.hpp"
#include "system/one_component.hpp"
#include "system/wall_map.hpp"

namespace tandem::test {
namespace {

TEST_F(OneComponent, TheFrameOfAJoyIsADevicesNameAndNeverRefused) {
  const auto teleop = load("teleop", {{"map_is_odom", "true"}});
  const auto joy = node_.create_publisher(topics::joy);
  std::set<std::string> drives;
  std::string frame;
  const auto user = node_.create_subscription(topics::cmd_vel_user, [&](const auto& msg) {
    if (msg.linear().x() > 0.0) drives.insert(frame);
  });
  for (const char* name : {"map", "odom", "/dev/input/js0", ""}) {
    frame = name;
    bool held = false;
    int beats_held = 0;  // the first ones at rest
    const auto push = node_.create_wall_timer(kBeat, [&] {
      sensor_msgs::msg::Joy msg;
      msg.header(header(node_.stamp(), frame));
      msg.axes({0.0F, held && ++beats_held > 5 ? 0.5F : 0.0F});
      msg.buttons({held ? 1 : 0, 0});
      joy.publish(msg);
    });
    const double begin = node_.steady_now();
    ASSERT_TRUE(wait_until([&] { return node_.steady_now() - begin > 0.6; }));  // another's turn
    held = true;
    EXPECT_TRUE(wait_until([&] { return drives.contains(frame); })) << name;
  }
}

// What is published in `nowhere` on one topic.
struct Stray {
  std::string topic, component;
  Values values;
  std::function<std::function<void()>(rt::Node&)> publisher;
};

template <class M>
std::function<std::function<void()>(rt::Node&)> sends(const rt::Topic<M>& topic, M msg) {
  msg.header(header({}, "nowhere"));
  return [topic, msg](rt::Node& node) -> std::function<void()> {
    auto out = std::make_shared<rt::Publisher<M>>(node.create_publisher(topic));
    return [out, msg] { out->publish(msg); };
  };
}

std::vector<Stray> strays() {
  sensor_msgs::msg::LaserScan scan;
  scan.angle_increment(0.1F);
  scan.range_max(10.0F);
  scan.ranges().assign(60, 1.0F);
  const auto pose = to_msg(Pose2{}, header({}, "nowhere"));
  geometry_msgs::msg::PoseWithCovarianceStamped initial;
  initial.pose().pose(pose.pose());
  nav_msgs::msg::OccupancyGrid grid;
  grid.info().resolution(0.1F);
  grid.info().width(2);
  grid.info().height(2);
  grid.info().origin().orientation().w(1.0);
  grid.data().assign(4, 100);
  const Values method{{"method", "leader"}};
  return {{"leader_pose", "local_planner", method, sends(topics::leader_pose, pose)},
          {"goal_pose", "local_planner", method, sends(topics::goal_pose, pose)},
          {"obstacles", "local_planner", method, sends(topics::obstacles, {})},
          {"odom", "local_planner", method,
           sends(topics::odom, to_msg(Odometry{}, header({}, ""), "base_link"))},
          {"leader_pose", "driver", {{"route", "[1.0, 0.0]"}}, sends(topics::leader_pose, pose)},
          {"people", "obstacle_extractor", {{"people", "true"}}, sends(topics::people, {})},
          {"octomap_binary", "safety_filter", {}, sends(topics::octomap_binary, wall(""))},
          {"map", "safety_filter", {{"static_map", "grid"}}, sends(topics::map, grid)},
          {"octomap_local",
           "safety_filter",
           {{"map_source", "local"}},
           sends(topics::octomap_local, wall(""))},
          {"scan", "octomap_builder", {}, sends(topics::scan, scan)},
          {"cloud_in", "octomap_builder", {}, sends(topics::cloud_in, cloud_of({{1, 0, 0}}, {}))},
          {"initialpose",
           "diff_drive_sim",
           {{"map", source_path("maps/yard.bt")}},
           sends(topics::initial_pose, initial)}};
}

TEST_F(OneComponent, RefusesEverythingInAnUnknownFrame) {
  for (const Stray& stray : strays()) {
    SCOPED_TRACE(stray.topic + " of " + stray.component);
    const CapturedLog log;
    const auto component = load(stray.component, stray.values);
    const auto publish = stray.publisher(node_);
    const auto beat = node_.create_wall_timer(kBeat, publish);
    const auto is_named = [&] {
      std::istringstream lines{log.text()};
      for (std::string line; std::getline(lines, line);)
        if (line.find(stray.topic) != std::string::npos &&
            line.find("`nowhere`") != std::string::npos)
          return true;
      return false;
    };
    EXPECT_TRUE(wait_until(is_named));
  }
}

// The values of these topics depend on a frame: they are transformed or refused.
const std::set<std::string> kPlaced{"leader_pose",  "goal_pose", "octomap_binary", "octomap_local",
                                    "people",       "obstacles", "odom",           "tf",
                                    "tf_static",    "scan",      "cloud_in",       "ground_truth",
                                    "initial_pose", "map"};
// Commands: of the robot's own frame, whatever it is called, but not of map or odom.
const std::set<std::string> kOfRobot{"cmd_vel_stamped"};
// Nobody here reads a number of them that depends on a frame; a joystick's frame is a device.
const std::set<std::string> kUnread{"joy",           "plan",
                                    "user_path",     "planner_status",
                                    "filter_status", "arbitration_status",
                                    "collision",     "sensing_status",
                                    "diagnostics",   "amcl_pose"};
// Visualizations: each marker has its own header, and no node reads them.
const std::set<std::string> kShown{"hindsight_markers", "leader_markers", "obstacle_markers"};
const std::set<std::string> kWithoutHeader{"Twist", "Bool", "Clock", "JoyFeedback", "String"};

// A new topic has to be put into one of the lists, and its reader has to do what the list says.
TEST(Topics, EachWithAHeaderIsPlacedByItsFrameOrIsKnownNotToDependOnOne) {
  std::ifstream file{source_path("components/io/topics.hpp")};
  const std::string text{std::istreambuf_iterator<char>{file}, {}};
  const std::regex topic{R"(constexpr Topic<\w+::msg::(\w+)> (\w+)\{)"};
  int found = 0;
  for (std::sregex_iterator it{text.begin(), text.end(), topic}, end; it != end; ++it) {
    const std::string type = (*it)[1], name = (*it)[2];
    ++found;
    if (kWithoutHeader.contains(type)) continue;
    int lists = 0;
    for (const auto* list : {&kPlaced, &kOfRobot, &kUnread, &kShown})
      lists += list->contains(name) ? 1 : 0;
    EXPECT_EQ(lists, 1) << name << " of type " << type;
  }
  EXPECT_GT(found, 25);
}

}  // namespace
}  // namespace tandem::test
