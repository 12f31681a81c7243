// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_summary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace tandem {
namespace {

TEST(Median, OfThreeHasTheBootstrapsIntervalFromTheLeastToTheGreatest) {
  // P(median of a resample = least) = P(2 of 3 draws are it) = 7/27, far above 2.5 %.
  const auto median = median_of({5.0, 1.0, 3.0}).value();
  EXPECT_EQ(median.value, 3.0);
  EXPECT_EQ(median.low, 1.0);
  EXPECT_EQ(median.high, 5.0);
}

TEST(Median, OfOneValueIsThatValueAndOfNoneIsUndefined) {
  const auto median = median_of({2.0}).value();
  EXPECT_EQ(median.low, 2.0);
  EXPECT_EQ(median.high, 2.0);
  EXPECT_FALSE(median_of({}).has_value());
}

// The bootstrap as it is usually done: by drawing.
Estimate by_drawing(std::vector<double> values, std::mt19937& random) {
  std::uniform_int_distribution<std::size_t> pick{0, values.size() - 1};
  std::vector<double> medians;
  for (int draw = 0; draw < 20000; ++draw) {
    std::vector<double> again(values.size());
    for (double& value : again) value = values[pick(random)];
    medians.push_back(quantiles(again).p50);
  }
  std::sort(medians.begin(), medians.end());
  return {quantiles(values).p50, medians[500], medians[19500]};
}

TEST(Median, HasTheIntervalThatDrawingGives) {
  std::mt19937 random{5};
  for (const std::size_t n : {5u, 10u, 21u, 50u}) {
    std::vector<double> values(n);  // ranks, so that a rank off is 1
    for (std::size_t i = 0; i < n; ++i) values[i] = static_cast<double>(i);
    const auto exact = median_of(values).value(), drawn = by_drawing(values, random);
    EXPECT_EQ(exact.value, drawn.value) << n;
    EXPECT_NEAR(exact.low, drawn.low, 1.0) << n;
    EXPECT_NEAR(exact.high, drawn.high, 1.0) << n;
  }
}

TEST(Share, HasWilsonsInterval) {
  // Wilson 1927 for 0 of n: from 0 to z² / (n + z²).
  const auto none = share_of(0, 20).value();
  EXPECT_EQ(none.value, 0.0);
  EXPECT_NEAR(none.low, 0.0, 1e-12);
  EXPECT_NEAR(none.high, 1.96 * 1.96 / (20.0 + 1.96 * 1.96), 1e-12);
  const auto half = share_of(10, 20).value();
  EXPECT_NEAR(0.5 * (half.low + half.high), 0.5, 1e-12);
  EXPECT_FALSE(share_of(0, 0).has_value());
}

DriveResult drive_of(const std::string& method, int collisions, double time) {
  DriveResult drive;
  drive.scenario = "s";
  drive.method = method;
  drive.driver = "d";
  drive.collisions = collisions;
  drive.reached = time > 0.0;
  drive.time_to_goal_s = time;
  drive.simulated_s = 10.0;
  drive.stuck_s = 1.0;
  return drive;
}

TEST(Summary, AddsUpEachGroup) {
  const auto summary = summary_of(groups_of({drive_of("a", 2, 5.0), drive_of("b", 0, 7.0),
                                             drive_of("a", 1, -1.0), drive_of("a", 0, 9.0)}));
  ASSERT_EQ(summary.size(), 2u);
  const auto& a = summary[0];
  EXPECT_EQ(a.at("method"), "a");
  EXPECT_EQ(a.at("n"), 3);
  EXPECT_EQ(a.at("reached"), 2);
  EXPECT_EQ(a.at("collisions"), 3);
  EXPECT_EQ(a.at("drives_with_a_collision"), 2);
  EXPECT_NEAR(a.at("stuck_share").get<double>(), 0.1, 1e-12);
  EXPECT_EQ(a.at("medians").at("time_to_goal_s").at("value"), 5.0);  // of those that arrived
  EXPECT_TRUE(a.at("medians").at("path_ratio").is_null());
  EXPECT_TRUE(a.at("intervention_rate").is_null());
}

TEST(Summary, GivesBarnsScoreAsTheMeanOverItsWorldsAndNothingElsewhere) {
  auto first = drive_of("a", 0, 5.0), second = first, elsewhere = drive_of("b", 0, 5.0);
  first.barn_score = 0.5;
  second.barn_score = 0.0;
  const auto groups = groups_of({first, second, elsewhere});
  const auto summary = summary_of(groups);
  EXPECT_EQ(summary[0].at("barn_score"), 0.25);
  EXPECT_TRUE(summary[1].at("barn_score").is_null());
  EXPECT_NE(study_table(groups).find("BARN's score 0.250"), std::string::npos);
}

TEST(Csv, HasARowPerDriveAndQuotesWhatNeedsIt) {
  auto drive = drive_of("a,\"b\"", 0, 5.0);
  drive.failures = {"one", "two"};
  const std::string csv = csv_of({drive, drive});
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_NE(csv.find("\"a,\"\"b\"\"\""), std::string::npos);
  EXPECT_NE(csv.find("one; two"), std::string::npos);
  EXPECT_NE(csv.find("plan_ms.p99"), std::string::npos);
}

}  // namespace
}  // namespace tandem
