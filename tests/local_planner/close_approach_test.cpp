// SPDX-License-Identifier: Apache-2.0
// Tests when a person who keeps pushing overrides the planner near an obstacle.
#include "tandem/local_planner/close_approach.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "local_planner/requests.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem::test {
namespace {

constexpr Twist2 kPush{0.8, 0.0};

class CloseApproachTest : public ::testing::Test {
 protected:
  CloseApproachTest() : body_{body_of(params_, robot_)} { stand_before_pole(0.15); }

  // A pole straight ahead, so far from the discs.
  void stand_before_pole(double gap) {
    const double front = body_.discs.back().p_BC.x() + body_.discs.back().radius;
    obstacles_ = {pole(front + gap + 0.225, 0.0)};
  }
  // The plan holds one twist.
  static Plan plan_of(const Twist2& twist) {
    Plan plan{.X_MB = {{}}};
    for (int k = 0; k < 15; ++k) {
      plan.twist.push_back(twist);
      plan.X_MB.push_back(integrate(plan.X_MB.back(), twist, plan.dt));
    }
    return plan;
  }
  std::optional<Twist2> next(const Twist2& user, const Twist2& planned) {
    return next_by(plan_of(planned), user);
  }
  std::optional<Twist2> next_by(const Plan& plan, const Twist2& user) {
    PlanRequest request{.method = method_,
                        .t = t_ += params_.control_period,
                        .X_MB = X_MB_,
                        .measured = measured_,
                        .user = user,
                        .obstacles = obstacles_,
                        .guarded = guarded_};
    return approach_.instead_of(plan, begin_cycle(request, params_, robot_, body_));
  }
  std::optional<Twist2> after_a_second(const Twist2& user, const Twist2& planned) {
    for (int i = 0; i < 19; ++i) (void)next(user, planned);
    return next(user, planned);
  }

  NmpcParams params_ = unlimited();
  RobotParams robot_;
  Body body_;
  Method method_ = Method::kIntention;
  std::vector<Obstacle> obstacles_;
  bool guarded_ = true;
  Pose2 X_MB_;
  Twist2 measured_;
  double t_ = 0.0;
  CloseApproach approach_;
};

TEST_F(CloseApproachTest, GivesAPersonWhoKeepsPushingTheirOwnTwistSlowedDown) {
  EXPECT_FALSE(next(kPush, {}));  // not for a single plan
  const auto twist = after_a_second({0.8, 0.32}, {});
  ASSERT_TRUE(twist);
  EXPECT_NEAR(twist->v, 0.5, 1e-12);
  EXPECT_NEAR(twist->w, 0.2, 1e-12);  // the same arc
  EXPECT_TRUE(approach_.is_near());
}

TEST_F(CloseApproachTest, TurnsOnTheSpotAndDrivesBackLikewise) {
  const auto turn = after_a_second({0.0, -1.2}, {});
  ASSERT_TRUE(turn);
  EXPECT_NEAR(turn->w, -0.8, 1e-12);
  const auto back = after_a_second({-0.8, 0.0}, {});
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->v, -0.5, 1e-12);
}

TEST_F(CloseApproachTest, FollowsAPlanThatMakesProgress) {
  EXPECT_FALSE(after_a_second(kPush, {0.2, 0.0}));
  ASSERT_TRUE(after_a_second(kPush, {0.05, 0.0}));
  EXPECT_TRUE(next(kPush, {0.2, 0.0}));  // not at once, or the robot would go to and fro
  EXPECT_FALSE(next(kPush, {0.5, 0.0}));
  EXPECT_FALSE(next(kPush, {0.05, 0.0}));
}

TEST_F(CloseApproachTest, MakesASlowPersonNoFaster) {
  const Twist2 slow{0.2, 0.05};
  EXPECT_EQ(after_a_second(slow, {}), slow);
}

TEST_F(CloseApproachTest, DoesNotWaitForAPlanThatPromisesWhatItNeverBegins) {
  Plan later = plan_of({0.8, 0.0});
  for (std::size_t k = 0; k < later.twist.size(); ++k) {
    if (k < 6) later.twist[k] = {};
    later.X_MB[k + 1] = integrate(later.X_MB[k], later.twist[k], later.dt);
  }
  std::optional<Twist2> twist;
  for (int i = 0; i < 20; ++i) twist = next_by(later, kPush);
  EXPECT_TRUE(twist);
  method_ = Method::kLeader;  // which may have to let its leader pass first
  approach_ = {};
  for (int i = 0; i < 20; ++i) twist = next_by(later, kPush);
  EXPECT_FALSE(twist);
}

// Such a plan brakes long before the person would.
TEST_F(CloseApproachTest, TakesOverFromAPlanThatHoldsBackAPersonWhoIsSlowAlready) {
  const Twist2 slow{0.4, 0.0}, held_back{0.2, 0.0}, follows{0.3, 0.0};
  measured_ = {0.3, 0.0};
  EXPECT_FALSE(after_a_second(slow, follows));
  EXPECT_FALSE(after_a_second(kPush, {0.4, 0.0})) << "who drives fast is to brake early";
  EXPECT_EQ(after_a_second(slow, held_back), slow);
  approach_ = {};
  method_ = Method::kLeader;
  EXPECT_FALSE(after_a_second(slow, held_back)) << "it may let its leader pass first";
}

TEST_F(CloseApproachTest, WithALeaderOnlyOnceTheRobotIsAboutToStand) {
  method_ = Method::kLeader;
  measured_ = {0.4, 0.0};
  EXPECT_FALSE(after_a_second(kPush, {}));
  measured_ = {0.3, 0.0};
  EXPECT_TRUE(after_a_second(kPush, {}));
}

// Otherwise it would back out and turn, only to stand a little nearer to the leader.
TEST_F(CloseApproachTest, WithALeaderWhileThePlanDrivesTheOtherWay) {
  method_ = Method::kLeader;
  measured_ = {-0.3, 0.0};
  EXPECT_TRUE(after_a_second(kPush, {-0.3, 0.4}));
  EXPECT_FALSE(after_a_second({-0.8, 0.0}, {-0.3, 0.4}));
}

// They want past what is in the way.
TEST_F(CloseApproachTest, NotForAPersonWhoTurnsTheStick) {
  EXPECT_FALSE(after_a_second({0.6, 0.4}, {}));
}

TEST_F(CloseApproachTest, EndsWhenTheStickIsPulledBack) {
  ASSERT_TRUE(after_a_second(kPush, {}));
  EXPECT_FALSE(next({-0.4, 0.0}, {}));
}

TEST_F(CloseApproachTest, GivesUpAfterFiveSecondsOfPushingInVain) {
  ASSERT_TRUE(after_a_second(kPush, {}));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(after_a_second(kPush, {}));
  (void)after_a_second(kPush, {});
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(after_a_second(kPush, {}));
  X_MB_.x -= 0.6;
  obstacles_.front().p_MO.x() -= 0.6;
  EXPECT_TRUE(after_a_second(kPush, {})) << "elsewhere it may help again";
}

TEST_F(CloseApproachTest, IsThereAgainAfterTheStickWasAtRest) {
  for (int i = 0; i < 7; ++i) (void)after_a_second(kPush, {});
  ASSERT_FALSE(next(kPush, {}));
  EXPECT_FALSE(next({}, {}));
  EXPECT_TRUE(after_a_second(kPush, {}));
}

TEST_F(CloseApproachTest, NeverWithoutAFilterThatEnforcesNorFarFromObstaclesNorForAGoalNorAtRest) {
  guarded_ = false;
  EXPECT_FALSE(after_a_second(kPush, {}));
  guarded_ = true;
  EXPECT_FALSE(after_a_second({}, {}));
  method_ = Method::kGoal;
  EXPECT_FALSE(after_a_second(kPush, {}));
  method_ = Method::kLeader;
  stand_before_pole(0.40);
  EXPECT_FALSE(after_a_second(kPush, {}));
  stand_before_pole(0.30);
  EXPECT_TRUE(after_a_second(kPush, {}));
  stand_before_pole(0.40);
  EXPECT_TRUE(next(kPush, {}));  // a little farther to leave than to begin
  stand_before_pole(0.50);
  EXPECT_FALSE(next(kPush, {}));
}

}  // namespace
}  // namespace tandem::test
