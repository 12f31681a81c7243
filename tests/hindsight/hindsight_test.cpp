// SPDX-License-Identifier: Apache-2.0
#include "tandem/hindsight/hindsight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

const RobotParams kMir{};
constexpr double kPeriod = 0.05;

// 10 m × 10 m with walls only along the border.
StaticMap hall() {
  Grid grid{0.05, {-5.0, -5.0}, 200, 200, std::vector<Cell>(40000, Cell::kFree)};
  for (int i = 0; i < 200; ++i)
    for (const auto& [x, y] : {std::pair{i, 0}, {i, 199}, {0, i}, {199, i}})
      grid.cells[grid.index(x, y)] = Cell::kOccupied;
  return StaticMap{std::move(grid)};
}

// Two goals ahead, left and right, and one behind.
HindsightParams three_goals() {
  HindsightParams params;
  params.goals = {3.0, 2.0, 0.0, 3.0, -2.0, 0.0, -3.0, 0.0, 3.14};
  return params;
}

Hindsight in_the_hall(const HindsightParams& params = three_goals()) {
  Hindsight hindsight{params, kMir};
  hindsight.on_map(hall());
  return hindsight;
}

double sum(const std::vector<double>& belief) {
  return std::accumulate(belief.begin(), belief.end(), 0.0);
}

// The robot executes hindsight's commands for a person whose input is constant.
Pose2 drive(Hindsight& hindsight, Pose2 X_MB, const Twist2& user, double duration) {
  for (double t = 0.0; t < duration; t += kPeriod)
    X_MB = integrate(X_MB, hindsight.assist(X_MB, user, t).command, kPeriod);
  return X_MB;
}

TEST(Hindsight, BelievesInAllGoalsAlikeAtFirst) {
  Hindsight hindsight = in_the_hall();
  const auto [command, belief] = hindsight.assist({}, {}, 0.0);
  EXPECT_EQ(command, Twist2{});
  ASSERT_EQ(belief.size(), 3);
  for (const double b : belief) EXPECT_DOUBLE_EQ(b, 1.0 / 3.0);
}

TEST(Hindsight, AStickAtRestGivesRestAndNoEvidence) {
  Hindsight hindsight = in_the_hall();
  for (double t = 0.0; t < 5.0; t += kPeriod) {
    const auto [command, belief] = hindsight.assist({}, {}, t);
    EXPECT_EQ(command, Twist2{});
    EXPECT_DOUBLE_EQ(belief[0], 1.0 / 3.0);
  }
}

TEST(Hindsight, LearnsWhichGoalIsMeant) {
  Hindsight hindsight = in_the_hall();
  std::vector<double> belief;
  for (double t = 0.0; t < 1.5; t += kPeriod) belief = hindsight.assist({}, {0.4, 0.6}, t).belief;
  EXPECT_GT(belief[0], 0.8);
  EXPECT_NEAR(sum(belief), 1.0, 1e-9);
}

TEST(Hindsight, BetweenTwoGoalsThePersonIsFollowed) {
  Hindsight hindsight = in_the_hall();
  Assistance out;
  for (double t = 0.0; t < 1.0; t += kPeriod) out = hindsight.assist({}, {0.6, 0.0}, t);
  EXPECT_NEAR(out.belief[0], out.belief[1], 0.02);
  EXPECT_NEAR(out.command.w, 0.0, 0.11);  // one step of the grid
  EXPECT_GT(out.command.v, 0.4);
}

TEST(Hindsight, SteersOnceItIsSure) {
  Hindsight hindsight = in_the_hall();
  // Turned toward the left goal, the person goes straight on from there, past it: it turns in.
  const Pose2 X = drive(hindsight, {0.0, 0.0, 0.45}, {0.7, 0.0}, 4.5);
  EXPECT_LT((X.position() - Eigen::Vector2d{3.0, 2.0}).norm(), 0.5);
  const Pose2 alone = integrate({0.0, 0.0, 0.45}, {0.7, 0.0}, 4.5);
  EXPECT_GT((alone.position() - Eigen::Vector2d{3.0, 2.0}).norm(), 0.5);
}

TEST(Hindsight, GivesInWhenThePersonThinksBetterOfIt) {
  Hindsight hindsight = in_the_hall();
  std::vector<double> belief;
  double t = 0.0;
  for (; t < 3.0; t += kPeriod) belief = hindsight.assist({}, {0.4, 0.6}, t).belief;
  ASSERT_GT(belief[0], 0.9);
  for (; t < 6.0; t += kPeriod) belief = hindsight.assist({}, {0.4, -0.6}, t).belief;
  EXPECT_GT(belief[1], 0.8);
}

TEST(Hindsight, IsNeverMoreVigorousThanThePerson) {
  Hindsight hindsight = in_the_hall();
  double t = 0.0;
  for (const double share : {0.1, 0.3, 0.7, 1.0})
    for (double angle = 0.0; angle < 6.0; angle += 0.3, t += kPeriod) {
      const Twist2 user{share * kMir.v_max * std::cos(angle), share * kMir.w_max * std::sin(angle)};
      const Twist2 limited = limit(user, kMir);
      const double most = std::max(std::abs(limited.v) / (limited.v < 0 ? -kMir.v_min : kMir.v_max),
                                   std::abs(limited.w) / kMir.w_max);
      const Twist2 out = hindsight.assist({1.0, 0.5, angle}, user, t).command;
      EXPECT_LE(std::abs(out.w) / kMir.w_max, std::max(most, share) + 1e-9);
      EXPECT_LE(out.v, std::max(most, share) * kMir.v_max + 1e-9);
      EXPECT_GE(out.v, std::max(most, share) * kMir.v_min - 1e-9);
    }
}

TEST(Hindsight, PassesOnCommandsItCannotRate) {
  Hindsight without{three_goals(), kMir};
  EXPECT_EQ(without.assist({}, {0.5, 0.1}, 0.0).command, (Twist2{0.5, 0.1}));
  Hindsight hindsight = in_the_hall();  // and outside of the map
  EXPECT_EQ(hindsight.assist({50.0, 0.0, 0.0}, {0.5, 0.1}, 0.0).command, (Twist2{0.5, 0.1}));
  HindsightParams walled_up = three_goals();
  walled_up.goals = {70.0, 0.0, 0.0};
  Hindsight nowhere = in_the_hall(walled_up);
  EXPECT_EQ(nowhere.assist({}, {0.5, 0.1}, 0.0).command, (Twist2{0.5, 0.1}));
}

TEST(Hindsight, AnUnreachableGoalDoesNotAffectOthers) {
  HindsightParams params;
  params.goals = {3.0, 2.0, 0.0, 70.0, 0.0, 0.0};
  Hindsight hindsight = in_the_hall(params);
  const Pose2 X = drive(hindsight, {0.0, 0.0, 0.45}, {0.7, 0.0}, 4.5);
  EXPECT_LT((X.position() - Eigen::Vector2d{3.0, 2.0}).norm(), 0.5);
}

TEST(Hindsight, ASilenceCountsAsOneSample) {
  Hindsight quick = in_the_hall(), slow = in_the_hall();
  (void)quick.assist({}, {0.4, 0.6}, 0.0);
  (void)slow.assist({}, {0.4, 0.6}, 0.0);
  const double soon = quick.assist({}, {0.4, 0.6}, 0.2).belief[0];
  EXPECT_DOUBLE_EQ(slow.assist({}, {0.4, 0.6}, 60.0).belief[0], soon);
}

TEST(Hindsight, RefusesInvalidGoals) {
  HindsightParams params;
  EXPECT_THROW(Hindsight(params, kMir), std::invalid_argument);
  params.goals = {1.0, 2.0};
  EXPECT_THROW(Hindsight(params, kMir), std::invalid_argument);
  params = three_goals();
  params.lookahead = -1.0;
  EXPECT_THROW(Hindsight(params, kMir), std::invalid_argument);
  RobotParams backward = kMir;
  backward.v_max = 0.0;
  EXPECT_THROW(Hindsight(three_goals(), backward), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
