// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "system/planner_over_dds.hpp"

namespace tandem::test {
namespace {

TEST_F(PlannerOverDds, StandsUntilThereIsAGoalAndThenDrivesThere) {
  ASSERT_TRUE(wait_until_standing(Reason::kNoGoal));
  EXPECT_EQ(X_, Pose2{});
  std::size_t planned = 0;
  const auto plan = node_.create_subscription(
      topics::plan, [&](const auto& msg) { planned = msg.poses().size(); });
  send_goal({0.8, 0.0, 0.0});
  EXPECT_TRUE(wait_until([&] { return std::abs(X_.x - 0.8) < 0.1 && command_.v < 0.1; }));
  EXPECT_TRUE(wait_until([&] { return planned == 16; }));  // the default horizon
}

// The distance to a wall is tested on the core: a busy machine adds delays that no robot has.
TEST_F(PlannerOverDds, SlowsDownForAWallInItsWay) {
  around_ = {wall_at(2.0)};
  send_goal({5.0, 0.0, 0.0});
  ASSERT_TRUE(wait_until([&] { return X_.x > 0.4 && command_.v > 0.0; }));
  EXPECT_TRUE(wait_until([&] { return command_.v < 0.25; }));
  EXPECT_LT(X_.x, 2.0);
}

TEST_F(PlannerOverDds, SilentObstaclesAreAReasonToStand) {
  ASSERT_TRUE(wait_until_driving());
  sees_obstacles_ = false;
  EXPECT_TRUE(wait_until_standing(Reason::kObstaclesSilent));
  sees_obstacles_ = true;
  EXPECT_TRUE(wait_until([&] { return command_.v > 0.2; }));
}

TEST_F(PlannerOverDds, OdometryThatIsNotANumberIsIgnored) {
  ASSERT_TRUE(wait_until_driving());
  sees_nan_ = true;
  EXPECT_TRUE(wait_until_standing(Reason::kNotLocalized));
  EXPECT_GE(log_.lines("odom is not finite: dropped"), 1);
}

TEST_F(PlannerOverDds, RefusesAGoalThatIsNotANumberAndKeepsTheOldOne) {
  send_goal({kNaN, 0.0, 0.0});
  ASSERT_TRUE(wait_until([&] { return log_.lines("goal_pose is not finite: dropped") == 1; }));
  ASSERT_TRUE(wait_until_standing(Reason::kNoGoal));
  ASSERT_TRUE(wait_until_driving());
  send_goal({5.0, 0.0, kNaN});
  const double before = X_.x;
  EXPECT_TRUE(wait_until([&] { return X_.x > before + 0.5 && command_.v > 0.2; }));
}

TEST_F(PlannerOverDds, RefusesAGoalInAnotherFrameAndAcceptsOneWithoutAFrame) {
  goal_.publish(to_msg(Pose2{5.0, 0.0, 0.0}, header({}, "odom")));
  ASSERT_TRUE(wait_until(
      [&] { return log_.lines("goal_pose is given in frame `odom`, not `map`: dropped") == 1; }));
  ASSERT_TRUE(wait_until_standing(Reason::kNoGoal));
  goal_.publish(to_msg(Pose2{5.0, 0.0, 0.0}, header({}, "")));
  EXPECT_TRUE(wait_until([&] { return command_.v > 0.2; }));
}

TEST_F(PlannerOverDds, AnObstacleThatIsNotANumberIsDroppedAndTheOthersAreKept) {
  ASSERT_TRUE(wait_until_driving());
  around_ = {{.p_MO = {kNaN, 0.0}, .a = 1.0, .b = 1.0}, wall_at(X_.x + 2.5)};
  const double wall = X_.x + 2.5;
  ASSERT_TRUE(wait_until([&] { return log_.lines("1 obstacles are not finite, or") > 0; }));
  EXPECT_TRUE(wait_until([&] { return command_.v < 0.25; }));
  EXPECT_LT(X_.x, wall);
}

TEST_F(PlannerOverDds, ReportsTheVerdictOnItsSolutionButNotOnceItStands) {
  ASSERT_TRUE(wait_until_driving());
  EXPECT_TRUE(wait_until([&] { return status_.verdict() == "confirmed"; }));
  EXPECT_EQ(status_.solver(), "structured");
  EXPECT_EQ(status_.source(), "solution");
  EXPECT_GT(status_.cost(), 0.0);
  const auto cycles = status_.cycles();
  sees_obstacles_ = false;
  ASSERT_TRUE(wait_until_standing(Reason::kObstaclesSilent));
  EXPECT_EQ(status_.source(), "standing");
  EXPECT_LT(status_.status(), 0);
  EXPECT_EQ(status_.solver() + status_.verdict(), "");
  EXPECT_EQ(status_.cost() + status_.cost_pose() + status_.cost_twist() + status_.cost_change(), 0);
  EXPECT_EQ(status_.solve_time() + status_.slack() + status_.clearance(), 0.0);
  EXPECT_EQ(status_.iterations() + status_.guesses() + status_.solves(), 0);
  EXPECT_GE(status_.cycles(), cycles) << "what is set at the start is kept";
}

// A goal so far away that its cost is not finite: no solver succeeds, and the last plan is used for
// a second.
TEST_F(PlannerOverDds, NamesEachRungOfTheFallbackLadder) {
  ASSERT_TRUE(wait_until_driving());
  EXPECT_EQ(status_.source(), "solution");
  rungs_.clear();
  send_goal({1e200, 0.0, 0.0});
  EXPECT_TRUE(wait_until([&] { return rungs_.contains("previous"); }));
  EXPECT_TRUE(wait_until([&] { return rungs_.contains("braking"); }));
  EXPECT_TRUE(wait_until([&] { return command_ == Twist2{} && status_.source() == "standing"; }));
  EXPECT_EQ(status_.solver() + status_.verdict(), "");
  EXPECT_TRUE(wait_until_driving());
}

class PlannerWithLocaliser : public PlannerOverDds {
 protected:
  PlannerWithLocaliser() : PlannerOverDds{{{"method", "goal"}, {"map_is_odom", "false"}}} {}
};

TEST_F(PlannerWithLocaliser, StandsUntilTheRobotIsLocalised) {
  send_goal({5.0, 0.0, 0.0});
  ASSERT_TRUE(wait_until_standing(Reason::kNotLocalized));
  EXPECT_EQ(X_, Pose2{});
  const auto tf = node_.create_publisher(topics::tf);
  tf2_msgs::msg::TFMessage msg;
  msg.transforms().push_back(to_transform(Pose2{}, header({}, "map"), "odom"));
  const auto localiser = node_.create_wall_timer(kBeat, [&] { tf.publish(msg); });
  EXPECT_TRUE(wait_until([&] { return command_.v > 0.2; }));
}

class IntentionOverDds : public PlannerOverDds {
 protected:
  IntentionOverDds() : PlannerOverDds{{{"method", "intention"}}} {}
};

TEST_F(IntentionOverDds, DoesWhatThePersonAsksAndStandsWhenTheyFallSilent) {
  ASSERT_TRUE(wait_until_standing(Reason::kUserSilent));
  user_ = {0.4, 0.0};
  ASSERT_TRUE(wait_until([&] { return std::abs(command_.v - 0.4) < 0.02; }));
  user_ = {kNaN, 0.0};  // no command at all
  EXPECT_TRUE(wait_until_standing(Reason::kUserSilent));
}

class LeaderOverDds : public PlannerOverDds {
 protected:
  LeaderOverDds() : PlannerOverDds{{{"method", "leader"}}} {}
};

TEST_F(LeaderOverDds, FollowsTheLeaderAndStandsWhenItFallsSilent) {
  ASSERT_TRUE(wait_until_standing(Reason::kLeaderSilent));
  const auto leader = node_.create_publisher(topics::leader_pose);
  auto lead = node_.create_wall_timer(kBeat, [&] {
    leader.publish(to_msg(Pose2{X_.x + 1.0, 0.0, 0.0}, header({}, "map")));
  });
  ASSERT_TRUE(wait_until([&] { return command_.v > 0.2; }));
  lead = {};
  EXPECT_TRUE(wait_until_standing(Reason::kLeaderSilent));
}

TEST_F(LeaderOverDds, ALeaderWithALateStampCountsAsSilent) {
  double age = 0.7;
  const auto leader = node_.create_publisher(topics::leader_pose);
  const auto lead = node_.create_wall_timer(kBeat, [&] {
    leader.publish(to_msg(Pose2{X_.x + 1.0, 0.0, 0.0}, header(ago(age), "map")));
  });
  ASSERT_TRUE(wait_until_standing(Reason::kLeaderSilent));
  age = 0.0;
  ASSERT_TRUE(wait_until([&] { return command_.v > 0.2; }));
  age = 0.7;
  EXPECT_TRUE(wait_until_standing(Reason::kLeaderSilent));
}

TEST_F(OneComponent, AParameterOutOfRangeStopsTheStartAndNamesIt) {
  try {
    (void)rt::load_component("local_planner", options("local_planner", {{"v_max", "99.0"}}));
    FAIL() << "started";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("v_max"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tandem::test
