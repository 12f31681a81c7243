// SPDX-License-Identifier: Apache-2.0
// Kills a component while the robot drives: the robot must stop in time.
#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

class Kill : public ::testing::TestWithParam<const char*> {};

TEST_P(Kill, StopsTheRobotInTime) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  const double killed_at = system.sim_time;
  double v = 0.0, w = 0.0;  // largest from then on: the last command may still have been obeyed
  const auto watch = [&] {
    v = std::max(v, std::abs(system.truth.twist.v));
    w = std::max(w, std::abs(system.truth.twist.w));
  };
  const std::string victim = GetParam();
  system.process(victim).send(SIGKILL);  // not waited for: it is watched what comes of it

  if (victim != "safety_filter") {  // after the filter nobody speaks: the base's own time-out acts
    ASSERT_TRUE(system.wait_until([&] { return watch(), system.command == Twist2{}; }, 5.0));
    EXPECT_LE(system.sim_time - killed_at, kZeroWithin + kOdomPeriod);
  }
  ASSERT_TRUE(system.wait_until([&] { return watch(), system.stands(); }, 5.0));
  const double braking = std::max(v / kBraking, w / kTurnBraking);
  EXPECT_LE(system.sim_time - killed_at, kZeroWithin + braking + 2 * kOdomPeriod);
  EXPECT_EQ(system.collisions, 0u);
}

INSTANTIATE_TEST_SUITE_P(Components, Kill,
                         ::testing::Values("teleop", "local_planner", "obstacle_extractor",
                                           "arbitration", "safety_filter"),
                         [](const auto& test) { return std::string(test.param); });

TEST(KillMapServer, ChangesNothing) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  system.kill_hard("map_server");
  const double killed_at = system.sim_time;
  const Pose2 there = system.truth.X;
  EXPECT_TRUE(system.wait_until(
      [&] {
        const double way = (system.truth.X.position() - there.position()).norm();
        return system.sim_time > killed_at + 3.0 && way > 0.5;
      },
      20.0));
  EXPECT_EQ(system.collisions, 0u);
}

TEST(KillPlanner, TheOthersSayWhyAndARestartDrivesOn) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  system.kill_hard("local_planner");
  ASSERT_TRUE(system.wait_until(
      [&] { return system.reason == Reason::kSharedSilent && system.stands(); }, 5.0));
  system.start("local_planner");
  EXPECT_TRUE(system.wait_until_driving());
}

TEST(KillFilter, ARestartDrivesOnWithinASecond) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  system.kill_hard("safety_filter");
  ASSERT_TRUE(system.wait_until([&] { return system.stands(); }, 5.0));
  // Measured from its first drive command: discovery time depends on the computer.
  system.command = {};  // the last one of the killed filter
  system.start("safety_filter");
  ASSERT_TRUE(system.wait_until([&] { return system.command.v > 0.05; }, 20.0));
  const double first_command = system.sim_time;
  ASSERT_TRUE(system.wait_until([&] { return system.truth.twist.v > 0.1; }, 20.0));
  // Under a sanitizer the base may find the new filter some seconds later than the watcher does.
  EXPECT_LE(system.sim_time - first_command, kInstrumented ? 20.0 : 1.0);
}

TEST(SecondSource, OfCmdVelMakesTheBaseStandUntilItIsGone) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  auto intruder = system.node().create_publisher(topics::cmd_vel);
  auto push = system.node().create_wall_timer(0.02, [&] {
    intruder.publish(to_msg(Twist2{0.8, 0.0}));
  });
  ASSERT_TRUE(system.wait_until([&] { return system.stands(); }, 5.0));
  const Pose2 there = system.truth.X;
  const double stood_at = system.sim_time;
  EXPECT_TRUE(system.wait_until([&] { return system.sim_time > stood_at + 3.0; }, 10.0));
  EXPECT_LT((system.truth.X.position() - there.position()).norm(), 0.01);
  push = {};
  EXPECT_TRUE(system.wait_until([&] { return system.truth.twist.v > 0.1; }, 20.0));
  EXPECT_EQ(system.collisions, 0u);
}

// The restarted node does not know whether the emergency stop was pressed.
TEST(KillArbitration, AfterARespawnItStandsUntilTheStopIsWithdrawnAndReleased) {
  SystemUnderTest system;
  for (const char* name : kComponents)
    if (std::string{name} != "arbitration") system.start(name);
  ChildProcess supervisor{"../tandem",
                          {"run", system.system(), "--separate", "--only", "arbitration"}};
  ASSERT_TRUE(system.wait_until_driving());
  const auto victims = children_of(supervisor.pid());
  ASSERT_EQ(victims.size(), 1u);
  kill(victims.front(), SIGKILL);
  ASSERT_TRUE(system.wait_until(
      [&] { return system.reason == Reason::kEmergencyStop && system.stands(); }, 20.0));

  const auto release = system.node().create_client(
      rt::ServiceName<std_srvs::srv::Trigger>{"arbitration/release_emergency_stop"});
  bool answered = false, released = true;
  const auto ask = [&] {
    answered = false;
    release.call({}, [&](const auto& response) {
      answered = true;
      released = response.success();
    });
    return system.wait_until([&] { return answered; }, 5.0);
  };
  ASSERT_TRUE(ask());
  EXPECT_FALSE(released) << "no publisher withdrew the stop";
  const auto e_stop = system.node().create_publisher(topics::e_stop);
  // Repeats the press: the killed node's subscriptions count as matched for another 20 s.
  const auto take_back =
      system.node().create_wall_timer(0.1, [&] { e_stop.publish(std_msgs::msg::Bool{}); });
  ASSERT_TRUE(system.wait_until([&] { return ask() && released; }, 20.0));
  EXPECT_EQ(system.collisions, 0u);
}

TEST(Terminate, EveryComponentEndsCleanlyOnSigterm) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  for (const char* name : kComponents) system.process(name).send(SIGTERM);
  for (const char* name : kComponents) EXPECT_EQ(system.process(name).wait(5.0), 0) << name;
}

}  // namespace
}  // namespace tandem::test
