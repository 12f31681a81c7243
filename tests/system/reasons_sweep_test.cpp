// SPDX-License-Identifier: Apache-2.0
// Every reason to stand that can be brought about with nodes in one process: arbitration names the
// first cause on its status and once in the log, with what would mend it.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "system/one_component.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/model/reasons.hpp"

namespace tandem::test {
namespace {

// Free ground about the robot, and a wall across its way if wanted.
octomap_msgs::msg::Octomap map_with_wall(double wall) {
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
  void run(const std::string& component, Values values = {}) {
    if (component != "arbitration") values.emplace("map_is_odom", "true");
    values.merge(patience(component));
    running_[component] = std::make_unique<rt::RunningComponent>(load(component, values));
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

  // It is given, with its remedy and number, and logged once more than before, with that.
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

TEST_F(Sweep, OfTheStick) {
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  expect_reason("cmd_vel_user is silent", Reason::kUserSilent);
  hold(0.9F);
  expect_reason("stick is not at rest", Reason::kStickMoved);
  hold(-100.0F);
  expect_reason("axis 1 of joy is beyond axis_range", Reason::kStickBeyondRange);
  hold(static_cast<float>(kNaN));
  expect_reason("axis 1 of joy is not finite", Reason::kStickNotFinite);
  stick_.axes({});
  expect_reason("joy has no axis", Reason::kStickIncomplete);
}

TEST_F(Sweep, OfArbitrationItself) {
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  push();
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; }));
  const auto button = node_.create_publisher(topics::e_stop);
  std_msgs::msg::Bool pressed;
  pressed.data(true);
  button.publish(pressed);
  expect_reason("emergency stop", Reason::kEmergencyStop);
  pressed.data(false);
  button.publish(pressed);
  const auto release = node_.create_client(
      rt::ServiceName<std_srvs::srv::Trigger>{"/arbitration/release_emergency_stop"});
  bool released = false;
  ASSERT_TRUE(wait_until([&] {
    release.call({}, [&](const auto& response) { released = released || response.success(); });
    return released;
  }));
  expect_reason("let go of the stick first", Reason::kLetGoFirst);
  pushes_ = false;
  hold(0.0F);
  expect_reason("steer to drive on", Reason::kSteerFirst);
}

TEST_F(Sweep, OfTheFilter) {
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  run("safety_filter");
  push();
  expect_reason("safety filter: no map yet", Reason::kNoMapYet);
  map_.publish(map_with_wall(3.0));
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; }));
  odom_on_ = false;
  expect_reason("safety filter: not localized", Reason::kNotLocalized);
  odom_on_ = true;
  twist_ = {9.0, 0.0};
  expect_reason("safety filter: odom is faster than the robot can be", Reason::kTooFast);
  twist_ = {};
  X_WB_.x += 1.0;
  expect_reason("safety filter: pose jumped", Reason::kPoseJumped);
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; }));
  map_.publish(map_with_wall(X_WB_.x + 0.56));
  expect_reason("safety filter: stopped", Reason::kStopped);
  end("safety_filter");
  expect_reason("safety filter is silent", Reason::kFilterSilent);
}

TEST_F(Sweep, OfAFilterThatWatchesPeople) {
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  run("safety_filter", {{"people", "true"}});
  map_.publish(map_with_wall(3.0));
  push();
  expect_reason("safety filter: people are silent", Reason::kPeopleSilent);
}

TEST_F(Sweep, OfAFilterThatMayNotDriveOverUnseenGround) {
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  run("safety_filter", {{"map_source", "local"}, {"unseen_speed", "0.0"}});
  push();
  octomap::OcTree nothing(0.05);
  nothing.updateNode(octomap::point3d(-3.0F, 0.0F, 0.3F), false);
  local_map_.data(encode_octomap(nothing));
  local_on_ = true;
  expect_reason("safety filter: unseen ground", Reason::kUnseenGround);
  local_on_ = false;
  expect_reason("safety filter: octomap_local is silent", Reason::kLocalMapSilent);
}

// What the planner waits for is followed to the node that lacks something.
TEST_F(Sweep, OfThePlannerAndWhatItWaitsFor) {
  run("arbitration", {{"policy", "shared"}, {"handover_time", "0.0"}});
  run("teleop");
  run("local_planner", {{"method", "intention"}});
  push();
  expect_reason("planner: obstacles are silent", Reason::kObstaclesSilent);
  run("obstacle_extractor", {{"map_source", "local"}});
  expect_reason("obstacle_extractor: no map yet", Reason::kNoMapYet);
  local_on_ = true;
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; })) << words_;
  local_on_ = false;
  expect_reason("obstacle_extractor: octomap_local is silent", Reason::kLocalMapSilent);
  run("octomap_builder");
  expect_reason("octomap_builder: nothing is heard on scan or cloud_in", Reason::kNothingSensed);
  end("octomap_builder");
  end("obstacle_extractor");
  local_on_ = true;
  run("obstacle_extractor", {{"map_source", "local"}, {"people", "true"}});
  expect_reason("obstacle_extractor: people are silent", Reason::kPeopleSilent);
}

TEST_F(Sweep, OfAPlannerThatIsNotThere) {
  run("arbitration", {{"policy", "shared"}, {"handover_time", "0.0"}});
  run("teleop");
  push();
  expect_reason("cmd_vel_shared is silent", Reason::kSharedSilent);
}

TEST_F(Sweep, OfThePlannersOwnInputs) {
  run("arbitration", {{"policy", "shared"}, {"handover_time", "0.0"}});
  run("teleop");
  local_on_ = true;
  run("obstacle_extractor", {{"map_source", "local"}});
  run("local_planner", {{"method", "goal"}});
  push();
  expect_reason("planner: no goal_pose yet", Reason::kNoGoal);
  end("local_planner");
  end("teleop");
  joy_on_ = pushes_ = false;
  const auto user = node_.create_publisher(topics::cmd_vel_user);
  const auto beat = node_.create_wall_timer(0.02, [&] { user.publish(to_msg(Twist2{0.3, 0.0})); });
  run("local_planner", {{"method", "leader"}});
  expect_reason("planner: leader_pose is silent", Reason::kLeaderSilent);
  odom_on_ = false;
  expect_reason("planner: not localized", Reason::kNotLocalized);
}

TEST_F(Sweep, OfAnAutonomousRobotWithoutAGoal) {
  run("arbitration", {{"policy", "autonomous"}, {"handover_time", "0.0"}});
  expect_reason("no command", Reason::kNoCommand);
}

// The filter, the extractor and the builder of a robot that drives by its sensors.
TEST_F(Sweep, OfSensors) {
  local_ = {};  // the builder's alone
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  run("octomap_builder", {{"scan_pose", "[0.0, 0.0, 0.3, 0.0, 0.0, 0.0]"}});
  run("safety_filter", {{"map_source", "local"}});
  push();
  expect_reason("octomap_builder: nothing is heard on scan or cloud_in", Reason::kNothingSensed);
  const auto scans = node_.create_publisher(topics::scan);
  sensor_msgs::msg::LaserScan scan;
  scan.header().frame_id("laser");
  scan.angle_min(-3.1F);
  scan.angle_increment(0.0172F);
  scan.angle_max(3.1F);
  scan.range_min(0.1F);
  scan.range_max(10.0F);
  double age = 0.0;
  auto beat = node_.create_wall_timer(0.05, [&] {
    scan.header().stamp(ago(age));
    scans.publish(scan);
  });
  scan.ranges().assign(360, 0.0F);
  expect_reason("octomap_builder: scan gives no valid range", Reason::kSensorBlind);
  scan.ranges().assign(360, 3.0F);
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; })) << words_;
  scan.angle_increment(static_cast<float>(kNaN));
  expect_reason("octomap_builder: scan is refused", Reason::kSensorRefused);
  scan.angle_increment(0.0172F);
  age = -2.0;
  expect_reason("octomap_builder: scan is dropped: no odometry of its time",
                Reason::kSensorUntimely);
  age = 0.0;
  scan.header().frame_id("map");
  expect_reason("octomap_builder: scan is dropped: it is given in frame `map`",
                Reason::kSensorInWorld);
  beat = {};
  expect_reason("octomap_builder: scan is silent: is its driver running?", Reason::kSensorSilent);
  end("octomap_builder");
  expect_reason("safety filter: octomap_local is silent", Reason::kLocalMapSilent);
}

TEST_F(Sweep, OfAClockThatStands) {
  run("arbitration", {{"policy", "manual"}, {"use_sim_time", "true"}});
  expect_reason("/clock is silent", Reason::kClockSilent);
}

}  // namespace
}  // namespace tandem::test
