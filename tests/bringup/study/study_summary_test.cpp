// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_summary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"

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

// The bounds of a million values are found without adding up a million terms for each.
TEST(Median, OfAMillionHasANarrowInterval) {
  std::vector<double> values(1'000'000);
  std::iota(values.begin(), values.end(), 0.0);
  const auto median = median_of(std::move(values)).value();
  EXPECT_EQ(median.value, 499'999.0);
  EXPECT_NEAR(median.high - median.value, 1.96 * 500.0, 2.0);  // √n / 2 ranks
  EXPECT_NEAR(median.value - median.low, 1.96 * 500.0, 2.0);
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

// A study of these drives, with seeds in their order.
class Stored : public ::testing::Test {
 protected:
  StudyFolder stored(std::vector<DriveResult> drives) {
    std::map<std::string, std::vector<unsigned>> seeds;
    nlohmann::json groups = nlohmann::json::array();
    for (unsigned seed = 1; DriveResult & drive : drives) {
      if (!seeds.contains(drive.method))
        groups.push_back({{"scenario", drive.scenario},
                          {"method", drive.method},
                          {"driver", drive.driver},
                          {"seeds", ""}});
      seeds[drive.method].push_back(drive.seed = seed++);
    }
    for (auto& group : groups) group["seeds"] = seed_ranges(seeds[group.at("method")]);
    StudyFolder folder{
        folder_.path(),
        {{"study", "t"}, {"description", nlohmann::json::object()}, {"groups", groups}}};
    for (const DriveResult& drive : drives)
      folder.results().add({{"drive", drive},
                            {"track", nlohmann::json::array()},
                            {"contacts", nlohmann::json::array()},
                            {"cost_s", 1.0}});
    return folder;
  }

 private:
  test::TemporaryFolder folder_;
};

using Summary = Stored;

TEST_F(Summary, AddsUpEachGroup) {
  const auto summary = summary_of(stored({drive_of("a", 2, 5.0), drive_of("b", 0, 7.0),
                                          drive_of("a", 1, -1.0), drive_of("a", 0, 9.0)}));
  ASSERT_EQ(summary.size(), 2u);
  const auto& a = summary[0];
  EXPECT_EQ(a.at("method"), "a");
  EXPECT_EQ(a.at("n"), 3);
  EXPECT_EQ(a.at("seeds"), "1,3-4");
  EXPECT_EQ(a.at("reached"), 2);
  EXPECT_EQ(a.at("collisions"), 3);
  EXPECT_EQ(a.at("drives_with_a_collision"), 2);
  EXPECT_NEAR(a.at("stuck_share").get<double>(), 0.1, 1e-12);
  EXPECT_EQ(a.at("medians").at("time_to_goal_s").at("value"), 5.0);  // of those that arrived
  EXPECT_TRUE(a.at("medians").at("path_ratio").is_null());
  EXPECT_TRUE(a.at("intervention_rate").is_null());
  EXPECT_TRUE(a.at("plan_ms").is_null());
}

TEST_F(Summary, OfTheFilterAndThePlannerCountsTheirDrives) {
  auto with = drive_of("a", 0, 5.0), without = with;
  with.counts.filter_commands = 100;
  with.counts.filter_interventions = 20;
  with.counts.plans = 50;
  with.plan_ms = {.p50 = 2.0, .p95 = 4.0, .p99 = 6.0, .max = 8.0};
  const auto group = summary_of(stored({with, without})).front();
  EXPECT_EQ(group.at("intervention_rate"), 0.2);
  EXPECT_EQ(group.at("plans"), 50);
  EXPECT_EQ(group.at("plan_ms"),
            (nlohmann::json{{"p50", 2.0}, {"p95", 4.0}, {"p99", 6.0}, {"max", 8.0}}));
}

TEST_F(Summary, GivesBarnsScoreAsTheMeanOverItsWorldsAndNothingElsewhere) {
  auto first = drive_of("a", 0, 5.0), second = first, elsewhere = drive_of("b", 0, 5.0);
  first.barn_score = 0.5;
  second.barn_score = 0.0;
  const auto summary = summary_of(stored({first, second, elsewhere}));
  EXPECT_EQ(summary[0].at("barn_score"), 0.25);
  EXPECT_TRUE(summary[1].at("barn_score").is_null());
  EXPECT_NE(study_table(summary).find("BARN's score 0.250"), std::string::npos);
}

TEST_F(Summary, NamesBuildAndMachine) {
  const auto origins = origins_of(stored({drive_of("a", 0, 5.0), drive_of("a", 0, 6.0)}));
  ASSERT_EQ(origins.size(), 1u);
  EXPECT_EQ(origins[0].at("build"), this_origin().build);
  EXPECT_NE(origins[0].at("machine").get<std::string>().find("glibc"), std::string::npos);
  EXPECT_EQ(origins[0].at("drives"), 2);
}

using Csv = Stored;

TEST_F(Csv, HasARowPerDriveAndQuotesWhatNeedsIt) {
  auto drive = drive_of("a,\"b\"", 0, 5.0);
  drive.failures = {"one", "two"};
  const std::string csv = csv_of(stored({drive, drive}));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_NE(csv.find("\"a,\"\"b\"\"\""), std::string::npos);
  EXPECT_NE(csv.find("one; two"), std::string::npos);
  EXPECT_NE(csv.find("plan_ms.p99"), std::string::npos);
}

}  // namespace
}  // namespace tandem
