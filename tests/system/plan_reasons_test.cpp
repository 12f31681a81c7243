// SPDX-License-Identifier: Apache-2.0
// Every reason for which the planner has no plan although all its inputs arrive, as reasons_sweep
// tests the others.
#include <limits>
#include <numbers>
#include <vector>

#include "system/reasons_sweep.hpp"

namespace tandem::test {
namespace {

// The robot is planned for among obstacles that the test publishes.
class SweepOfPlans : public Sweep {
 protected:
  void start(const Values& values) {
    run("arbitration", {{"policy", "shared"}, {"handover_time", "0.0"}});
    run("teleop");
    Values all = values;
    all.merge(Values{{"method", "goal"}, {"time_budget", "0.0"}});
    run("local_planner", all);
    push();
    expect_reason("planner: no goal_pose yet", Reason::kNoGoal);
    goal_.publish(to_msg(Pose2{4.0, 0.0, 0.0}, header({}, "map")));
    ASSERT_TRUE(wait_until([this] { return reason_ == Reason::kFollowsSource; })) << words_;
  }
  // A wall 8 m wide that comes at the robot faster than it can flee, in every message anew.
  void let_a_wall_come() {
    around_ = {{.p_MO = {1.6, 0.0},
                .a = 4.0,
                .b = 0.3,
                .angle = 0.5 * std::numbers::pi,
                .v_MO = {-4.0, 0.0}}};
  }

  std::vector<Obstacle> around_;
  rt::Publisher<tandem_msgs::msg::ObstacleArray> obstacles_ =
      node_.create_publisher(topics::obstacles);
  rt::Publisher<geometry_msgs::msg::PoseStamped> goal_ =
      node_.create_publisher(topics::goal_pose, rt::kLatched);
  rt::Timer list_ = node_.create_wall_timer(
      0.02, [this] { obstacles_.publish(to_msg(around_, header({}, "map"))); });
};

TEST_F(SweepOfPlans, ThatFailTheExactCheck) {
  start({});
  let_a_wall_come();
  expect_reason("planner: infeasible", Reason::kPlanInfeasible);
}

TEST_F(SweepOfPlans, ThatAreNotReadyInTime) {
  start({{"max_iterations", "1"}, {"extra_guesses", "0"}});
  let_a_wall_come();
  expect_reason("planner: timeout", Reason::kPlanTimeout);
}

// Finite in its own frame, but not in the map.
TEST_F(SweepOfPlans, ForAGoalThatIsNotFiniteInTheMap) {
  const auto tf_static = node_.create_publisher(topics::tf_static);
  tf2_msgs::msg::TFMessage msg;
  msg.transforms().push_back(
      to_transform({0.0, 0.0, 0.25 * std::numbers::pi}, header({}, "map"), "hall"));
  tf_static.publish(msg);
  start({});
  constexpr double kHuge = std::numeric_limits<double>::max();
  goal_.publish(to_msg(Pose2{kHuge, kHuge, 0.0}, header({}, "hall")));
  expect_reason("planner: refused", Reason::kPlanRefused);
  EXPECT_GT(log_.lines("no plan: a number of the request is not finite in `map`"), 0);
}

}  // namespace
}  // namespace tandem::test
