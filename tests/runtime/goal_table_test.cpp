// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/goal_table.hpp"

#include <gtest/gtest.h>

namespace tandem::runtime {
namespace {

constexpr double kTimeout = 10.0;  // [s] after which a result is forgotten
constexpr GoalId kFirst{1}, kSecond{2}, kThird{3}, kNone{};

// Three goals, accepted at 100, 200 and 300 ns and executing.
GoalTable three_goals() {
  GoalTable table{kTimeout};
  std::int64_t stamp = 0;
  for (const GoalId& id : {kFirst, kSecond, kThird}) {
    EXPECT_TRUE(table.accept(id, stamp += 100));
    EXPECT_TRUE(table.execute(id));
  }
  return table;
}

std::vector<GoalId> ids(const GoalTable::Selection& selection) {
  std::vector<GoalId> all;
  for (const auto& goal : selection.goals) all.push_back(goal.id);
  return all;
}

TEST(GoalTable, LeadsAGoalFromAcceptedToSucceeded) {
  GoalTable table{kTimeout};
  EXPECT_EQ(table.status(kFirst), GoalStatus::kUnknown);
  ASSERT_TRUE(table.accept(kFirst, 1));
  EXPECT_EQ(table.status(kFirst), GoalStatus::kAccepted);
  ASSERT_TRUE(table.execute(kFirst));
  EXPECT_EQ(table.status(kFirst), GoalStatus::kExecuting);
  ASSERT_TRUE(table.finish(kFirst, GoalStatus::kSucceeded, 0.0));
  EXPECT_EQ(table.status(kFirst), GoalStatus::kSucceeded);
}

TEST(GoalTable, RefusesAnIdThatItKnows) {
  GoalTable table{kTimeout};
  ASSERT_TRUE(table.accept(kFirst, 1));
  EXPECT_FALSE(table.accept(kFirst, 2));
  table.finish(kFirst, GoalStatus::kAborted, 0.0);
  EXPECT_FALSE(table.accept(kFirst, 3));
}

TEST(GoalTable, RefusesMoreThanItsMaximum) {
  GoalTable table{kTimeout};
  for (std::size_t i = 0; i < GoalTable::kMaxGoals; ++i) {
    const GoalId id{static_cast<std::uint8_t>(i % 256), static_cast<std::uint8_t>(i / 256)};
    ASSERT_TRUE(table.accept(id, 1));
  }
  EXPECT_FALSE(table.accept({0, 0, 1}, 1));
}

TEST(GoalTable, CancelsOnlyWhatIsCanceling) {
  GoalTable table = three_goals();
  EXPECT_FALSE(table.finish(kFirst, GoalStatus::kCanceled, 0.0));
  ASSERT_TRUE(table.start_canceling(kFirst));
  EXPECT_FALSE(table.start_canceling(kFirst));
  EXPECT_TRUE(table.finish(kFirst, GoalStatus::kCanceled, 0.0));
}

TEST(GoalTable, LetsAGoalThatIsCancelingSucceedOrAbort) {
  GoalTable table = three_goals();
  table.start_canceling(kFirst);
  table.start_canceling(kSecond);
  EXPECT_TRUE(table.finish(kFirst, GoalStatus::kSucceeded, 0.0));
  EXPECT_TRUE(table.finish(kSecond, GoalStatus::kAborted, 0.0));
}

TEST(GoalTable, EndsAGoalOnce) {
  GoalTable table = three_goals();
  ASSERT_TRUE(table.finish(kFirst, GoalStatus::kAborted, 0.0));
  EXPECT_FALSE(table.finish(kFirst, GoalStatus::kSucceeded, 0.0));
  EXPECT_FALSE(table.start_canceling(kFirst));
  EXPECT_FALSE(table.execute(kFirst));
  EXPECT_FALSE(table.finish(kSecond, GoalStatus::kExecuting, 0.0));
}

TEST(GoalTable, SelectsOneGoalByItsId) {
  const auto selection = three_goals().to_cancel(kSecond, 0);
  EXPECT_EQ(ids(selection), std::vector{kSecond});
  EXPECT_EQ(selection.answer, CancelAnswer::kNone);
}

TEST(GoalTable, SelectsAllGoalsWithoutIdAndStamp) {
  EXPECT_EQ(ids(three_goals().to_cancel(kNone, 0)), (std::vector{kFirst, kSecond, kThird}));
}

TEST(GoalTable, SelectsGoalsUpToAStampAndTheOneOfAnId) {
  EXPECT_EQ(ids(three_goals().to_cancel(kNone, 200)), (std::vector{kFirst, kSecond}));
  EXPECT_EQ(ids(three_goals().to_cancel(kThird, 100)), (std::vector{kFirst, kThird}));
}

TEST(GoalTable, SelectsNoneThatHasEndedAndSaysWhy) {
  GoalTable table = three_goals();
  table.finish(kFirst, GoalStatus::kSucceeded, 0.0);
  EXPECT_EQ(table.to_cancel(kFirst, 0).answer, CancelAnswer::kTerminated);
  EXPECT_EQ(table.to_cancel(GoalId{9}, 0).answer, CancelAnswer::kUnknown);
  EXPECT_EQ(ids(table.to_cancel(kNone, 0)), (std::vector{kSecond, kThird}));
}

TEST(GoalTable, ForgetsResultsAfterTheTimeout) {
  GoalTable table = three_goals();
  table.finish(kSecond, GoalStatus::kSucceeded, 5.0);
  EXPECT_TRUE(table.expire(5.0 + kTimeout).empty());
  EXPECT_EQ(table.expire(5.1 + kTimeout), std::vector{kSecond});
  EXPECT_EQ(table.status(kSecond), GoalStatus::kUnknown);
  EXPECT_EQ(table.goals().size(), 2U);
}

TEST(GoalTable, KeepsResultsForeverWithANegativeTimeout) {
  GoalTable table{-1.0};
  table.accept(kFirst, 1);
  table.finish(kFirst, GoalStatus::kAborted, 0.0);
  EXPECT_TRUE(table.expire(1e9).empty());
}

TEST(GoalId, IsAVersion4Uuid) {
  const GoalId id = make_goal_id();
  EXPECT_NE(id, make_goal_id());
  const std::string text = to_text(id);
  ASSERT_EQ(text.size(), 36U);
  EXPECT_EQ(text[14], '4');
  EXPECT_NE(std::string{"89ab"}.find(text[19]), std::string::npos);
}

}  // namespace
}  // namespace tandem::runtime
