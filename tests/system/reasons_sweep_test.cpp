// SPDX-License-Identifier: Apache-2.0
// Every reason to stand that can be brought about with nodes in one process: arbitration names the
// first cause on its status and once in the log, with what would mend it. Those of plans are in
// plan_reasons_test.
#include "system/reasons_sweep.hpp"

#include <cmath>

namespace tandem::test {
namespace {

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

TEST_F(Sweep, OfOdometryWhoseTwistContradictsItsPoses) {
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  run("safety_filter");
  map_.publish(map_with_wall(0.75));
  push();
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; })) << words_;
  twist_ = {0.8, 0.0};  // of a robot that does not move
  expect_reason("safety filter: stopped: odom's twist contradicts its poses",
                Reason::kTwistInDoubt);
}

// A node between arbitration and the filter that spoils commands.
TEST_F(Sweep, OfACommandThatIsNotFinite) {
  const rt::Publisher<geometry_msgs::msg::Twist> spoiled =
      node_.create_publisher(topics::cmd_vel_arbitrated);
  const rt::Topic<geometry_msgs::msg::Twist> decided{"cmd_vel_decided",
                                                     topics::cmd_vel_arbitrated.qos};
  double speed = 0.2;
  const auto relay = node_.create_subscription(decided, [&](const auto&) {
    spoiled.publish(to_msg(Twist2{speed, 0.0}));
  });
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}},
      {{topics::cmd_vel_arbitrated.name, decided.name}});
  run("teleop");
  run("safety_filter");
  map_.publish(map_with_wall(3.0));
  push();
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; })) << words_;
  speed = kNaN;
  expect_reason("safety filter: command not finite", Reason::kCommandNotFinite);
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
  expect_reason("octomap_builder: no data on scan or cloud_in", Reason::kNothingSensed);
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
  expect_reason("octomap_builder: no data on scan or cloud_in", Reason::kNothingSensed);
  const auto scans = node_.create_publisher(topics::scan);
  sensor_msgs::msg::LaserScan scan = round_scan();
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

// A driver that hangs sends its last scan for ever, while the robot drives on.
TEST_F(Sweep, OfASensorThatRepeatsWhatItSaw) {
  local_ = {};  // the builder's alone
  run("arbitration", {{"policy", "manual"}, {"handover_time", "0.0"}});
  run("teleop");
  run("octomap_builder", {{"scan_pose", "[0.0, 0.0, 0.3, 0.0, 0.0, 0.0]"}});
  run("safety_filter", {{"map_source", "local"}});
  push();
  const auto scans = node_.create_publisher(topics::scan);
  sensor_msgs::msg::LaserScan scan = round_scan();
  const auto beat = node_.create_wall_timer(0.05, [&] {
    scan.header().stamp(ago(0.0));
    scans.publish(scan);
  });
  ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; })) << words_;
  twist_ = {0.3, 0.0};
  const auto drive = node_.create_wall_timer(0.02, [this] { X_WB_.x += 0.006; });
  expect_reason("octomap_builder: scan is frozen", Reason::kSensorFrozen);
}

TEST_F(Sweep, OfAClockThatStands) {
  run("arbitration", {{"policy", "manual"}, {"use_sim_time", "true"}});
  expect_reason("/clock is silent", Reason::kClockSilent);
}

}  // namespace
}  // namespace tandem::test
