// SPDX-License-Identifier: Apache-2.0
// Runs two complete systems in one domain, separated by namespace: neither receives the other's
// data.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

// What the tester observes and commands of one robot.
class Robot {
 public:
  Robot(rt::Node& node, const std::string& ns)
      : cmd_vel_user_name_{ns + "/cmd_vel_user"},
        e_stop_name_{ns + "/e_stop"},
        truth_name_{ns + "/ground_truth/odom"},
        user_{node.create_publisher(
            rt::Topic<geometry_msgs::msg::Twist>{cmd_vel_user_name_.c_str()})},
        e_stop_{node.create_publisher(
            rt::Topic<std_msgs::msg::Bool>{e_stop_name_.c_str(), rt::kLatched})},
        truth_{node.create_subscription(
            rt::Topic<nav_msgs::msg::Odometry>{truth_name_.c_str()},
            [this](const auto& msg) { X_MB = from_msg(msg).value_or(Odometry{}).X; })},
        beat_{node.create_wall_timer(0.05, [this] {
          if (v > 0.0) user_.publish(to_msg(Twist2{v, 0.0}));
        })} {}

  void press_stop() {
    std_msgs::msg::Bool msg;
    msg.data(true);
    e_stop_.publish(msg);
  }

  double v = 0.0;  ///< the person's commanded speed [m/s]; 0: none
  std::optional<Pose2> X_MB;

 private:
  std::string cmd_vel_user_name_, e_stop_name_, truth_name_;
  rt::Publisher<geometry_msgs::msg::Twist> user_;
  rt::Publisher<std_msgs::msg::Bool> e_stop_;
  rt::Subscription truth_;
  rt::Timer beat_;
};

class TwoRobots : public testing::Test {
 protected:
  bool wait_until(const std::function<bool()>& done) {
    return spin_until(done, kLongTimeout, node_);
  }

  static double way(const Robot& robot, const Pose2& from) {
    return (robot.X_MB->position() - from.position()).norm();
  }

  // One drives, the other stands; then the one is stopped, and the other drives.
  void expect_no_cross_talk() {
    ASSERT_TRUE(wait_until([&] { return a_.X_MB && b_.X_MB; }));
    const Pose2 start_a = *a_.X_MB, start_b = *b_.X_MB;
    a_.v = 0.3;
    ASSERT_TRUE(wait_until([&] { return way(a_, start_a) > kTravelled; }));
    EXPECT_LT(way(b_, start_b), 1e-6);

    a_.press_stop();
    b_.v = 0.3;
    ASSERT_TRUE(wait_until([&] { return way(b_, start_b) > kTravelled / 2; }));
    const Pose2 stopped_a = *a_.X_MB;
    ASSERT_TRUE(wait_until([&] { return way(b_, start_b) > kTravelled; }));
    EXPECT_LT(way(a_, stopped_a), 1e-3);
  }

  rt::Node node_{"tester"};
  Robot a_{node_, "/a"}, b_{node_, "/b"};
};

std::vector<std::string> run_in(const std::string& ns) {
  return {"run",
          source_path("bringup/systems/teleop.yaml"),
          "--ros-args",
          "-r",
          "__ns:=" + ns,
          "-r",
          "/tf:=tf",
          "-r",
          "/clock:=clock",
          "-p",
          "arbitration:policy:=manual"};
}

TEST_F(TwoRobots, InTwoProcessesDoNotHearEachOther) {
  ChildProcess a{"../tandem", run_in("/a")}, b{"../tandem", run_in("/b")};
  expect_no_cross_talk();
}

// The teleoperated system under a namespace, as a system file's components.
std::string components_in(const std::string& ns) {
  const std::string map = source_path("maps/forest.bt");
  std::string text;
  const auto add = [&](const std::string& component, const std::string& parameters) {
    text += "  - {component: " + component + ", namespace: " + ns +
            ", remappings: {/tf: tf, /clock: clock}, parameters: {" + parameters + "}}\n";
  };
  add("map_server", "map: " + map);
  add("teleop", "");
  add("obstacle_extractor", "");
  add("local_planner", "");
  add("arbitration", "policy: manual");
  add("safety_filter", "");
  add("diff_drive_sim", "use_sim_time: false, start: [-4, -4, 0], map: " + map);
  return text;
}

TEST_F(TwoRobots, InOneProcessDoNotHearEachOther) {
  char name[] = "/tmp/tandem_two_robots_XXXXXX";
  const fs::path folder = mkdtemp(name);
  std::ofstream{folder / "two.yaml"} << "use_sim_time: true\nparameter_files: ["
                                     << source_path("bringup/robots/mir100.yaml")
                                     << "]\ncomponents:\n"
                                     << components_in("/a") << components_in("/b");
  {
    ChildProcess both{"../tandem", {"run", folder / "two.yaml"}};
    expect_no_cross_talk();
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace tandem::test
