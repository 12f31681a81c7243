// SPDX-License-Identifier: Apache-2.0
// Tests how long a plan leaves somebody who stands in the way to the person at the stick.
#include "tandem/local_planner/standing_people.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "local_planner/requests.hpp"
#include "tandem/local_planner/cycle.hpp"

namespace tandem::test {
namespace {

class StandingPeople : public ::testing::Test {
 protected:
  StandingPeople() : body_{body_of(params_, robot_)} {}

  // Somebody straight ahead, so far from the discs.
  [[nodiscard]] Obstacle somebody_at(double gap) const {
    const double front = body_.discs.back().p_BC.x() + body_.discs.back().radius;
    Obstacle person{1, {front + gap + 0.25, 0.0}, 0.25, 0.25};
    person.tracked = true;
    return person;
  }
  [[nodiscard]] bool avoids(const Obstacle& obstacle) const {
    const std::vector<Obstacle> all{pole(5.0, 5.0), obstacle};
    PlanRequest request = request_;
    request.obstacles = all;
    const std::size_t kept = obstacles_of_the_plan(request, body_, params_, robot_).size();
    EXPECT_GE(kept, 1U) << "a pole is always avoided";
    return kept == 2;
  }
  [[nodiscard]] double near() const {
    const double v = request_.command.v;
    return params_.margin + v * (params_.delay + 0.5) + v * v / (2.0 * robot_.a_max);
  }

  NmpcParams params_ = unlimited();
  RobotParams robot_;
  Body body_;
  PlanRequest request_{.method = Method::kIntention, .command = {0.8, 0.0}, .user = {0.8, 0.0}};
};

TEST_F(StandingPeople, AreAvoidedOnceTheRobotCouldNoLongerStopAReactionLater) {
  EXPECT_FALSE(avoids(somebody_at(near() + 0.01)));
  EXPECT_TRUE(avoids(somebody_at(near() - 0.01)));
  request_.command = {};
  EXPECT_FALSE(avoids(somebody_at(params_.margin + 0.01)));
  EXPECT_TRUE(avoids(somebody_at(params_.margin - 0.01)));
}

TEST_F(StandingPeople, AreJudgedByTheFasterOfCommandAndMeasuredSpeed) {
  const double gap = near() - 0.01;
  request_.command = {0.1, 0.0};
  EXPECT_FALSE(avoids(somebody_at(gap)));
  request_.measured = {0.8, 0.0};
  EXPECT_TRUE(avoids(somebody_at(gap)));
}

TEST_F(StandingPeople, AreAvoidedAtOnceIfTheStickTurnsOrTheyWalkOrAreNotTracked) {
  Obstacle person = somebody_at(near() + 0.5);
  person.v_MO = {-0.1, 0.0};
  EXPECT_TRUE(avoids(person));
  person = somebody_at(near() + 0.5);
  person.tracked = false;
  EXPECT_TRUE(avoids(person));
  for (const double turn : {-0.2, 0.2}) {
    request_.user.w = turn * robot_.w_max;
    EXPECT_TRUE(avoids(somebody_at(near() + 0.5))) << turn;
  }
}

TEST_F(StandingPeople, AreAvoidedAtOnceByMethodsThatFollowALeaderAPathOrAGoal) {
  for (const Method method : {Method::kLeader, Method::kPath, Method::kGoal}) {
    request_.method = method;
    EXPECT_TRUE(avoids(somebody_at(near() + 0.5))) << name(method);
  }
}

TEST_F(StandingPeople, DoNotTurnAPlanForAStraightStick) {
  for (const bool tracked : {true, false}) {
    Nmpc planner{params_, robot_};
    std::vector<Obstacle> all{somebody_at(near() + 0.3)};
    all[0].tracked = tracked;
    all[0].p_MO.y() = 0.1;
    request_.obstacles = all;
    double turned = 0.0;
    for (const Pose2& X_MB : planner.solve(request_).X_MB)
      turned = std::max(turned, std::abs(X_MB.theta));
    if (tracked)
      EXPECT_LT(turned, 0.01);
    else
      EXPECT_GT(turned, 0.1);
  }
}

}  // namespace
}  // namespace tandem::test
