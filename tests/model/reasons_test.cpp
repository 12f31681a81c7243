// SPDX-License-Identifier: Apache-2.0
// The table of reasons: complete, and the same in bringup/ROS2.md.
#include "tandem/model/reasons.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "tandem/arbitration/arbiter.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/octomap_builder/sensor_watch.hpp"
#include "tandem/safety_filter/safety_filter.hpp"
#include "tandem/teleop/teleop.hpp"

namespace tandem {
namespace {

// Collects every enumerator up to the first without a name.
template <class Enum>
std::vector<std::string> names_of(int first, const std::string& unknown) {
  std::vector<std::string> names;
  for (int i = first; name(static_cast<Enum>(i)) != unknown; ++i)
    names.emplace_back(name(static_cast<Enum>(i)));
  return names;
}

void expect_remedies(const std::vector<std::string>& reasons, const std::set<std::string>& none) {
  for (const auto& reason : reasons)
    EXPECT_EQ(remedy_for(reason).empty(), none.contains(reason)) << reason;
}

TEST(Reasons, OfTheFilterHaveARemedyUnlessItDrives) {
  const auto reasons = names_of<FilterReason>(0, "unknown");
  ASSERT_EQ(reasons.back(), name(FilterReason::kClockSilent));
  expect_remedies(reasons, {"clear", "slowed", "deflected", "backing out"});
}

TEST(Reasons, OfArbitrationHaveARemedyUnlessItDrives) {
  const auto reasons = names_of<ArbitrationReason>(0, "?");
  ASSERT_EQ(reasons.back(), name(ArbitrationReason::kClockSilent));
  expect_remedies(reasons, {"in charge", "handover", "the person takes over"});
}

TEST(Reasons, OfThePlannersFallbacksHaveARemedy) {
  for (const auto status : {PlanStatus::kTimeout, PlanStatus::kInfeasible, PlanStatus::kRefused})
    EXPECT_FALSE(remedy_for(std::string{"planner: "} + name(status)).empty()) << name(status);
}

TEST(Reasons, OfAStickHaveARemedy) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<int> pressed{1, 0};
  const auto trouble = [&](std::vector<float> axes, std::vector<int> buttons) {
    return check_joy(axes, buttons, TeleopParams{}).trouble;
  };
  for (const std::string& reason :
       {trouble({}, pressed), trouble({0.0F, nan}, pressed), trouble({0.0F, -100.0F}, pressed),
        trouble({0.0F, 0.0F}, {}), std::string{kNotAtRest}}) {
    EXPECT_FALSE(reason.empty());
    EXPECT_FALSE(remedy_for(reason).empty()) << reason;
  }
}

TEST(Reasons, OfASensorHaveARemedyOfTheirOwn) {
  SensorWatchParams required;
  required.required_sensors = {"scan"};
  std::set<std::string> remedies;
  const auto expect_remedy = [&](const std::string& reason) {
    ASSERT_FALSE(reason.empty());
    EXPECT_FALSE(remedy_for(reason).empty()) << reason;
    EXPECT_TRUE(remedies.insert(remedy_for(reason)).second) << reason;
  };
  SensorWatch never{"scan", required, 0.05};
  expect_remedy(never.reason(1.0));
  for (const std::string& trouble :
       {std::string{}, std::string{"gives no valid range (360 nan)"}, std::string{"is refused: x"},
        std::string{"is dropped: /tf_static does not say where its frame `x` is"},
        std::string{"is dropped: it is given in frame `map`, which does not move with the robot"},
        std::string{"is dropped: not localized: odom is silent"},
        std::string{"is dropped: no odometry of its time: its stamp is 2.0 s ahead of odometry's"},
        std::string{"is dropped: (9999, 0) is farther than an OctoMap reaches"}}) {
    SensorWatch watch{"scan", {}, 0.05};
    watch.on_trouble(trouble, 0.0);
    if (!trouble.empty()) watch.on_trouble(trouble, 1.0);
    expect_remedy(watch.reason(1.1));
  }
}

TEST(Reasons, AreFoundBehindTheNodeThatGaveThemAndTheLongestCounts) {
  EXPECT_EQ(remedy_for("safety filter: no map yet"), words(Reason::kNoMapYet).remedy);
  EXPECT_EQ(remedy_for("stopped: odom's twist contradicts its poses"),
            words(Reason::kTwistInDoubt).remedy);
  EXPECT_EQ(remedy_for("safety filter: stopped"), words(Reason::kStopped).remedy);
  EXPECT_EQ(remedy_for("not localized: odom is given in frame `world`, not `odom`"),
            words(Reason::kOtherFrame).remedy);
  EXPECT_EQ(remedy_for("no mapping"), "");
  EXPECT_EQ(remedy_for(""), "");
}

TEST(Reasons, OfAPublishedTextAreFoundInTheTable) {
  EXPECT_EQ(reason_in("safety filter: no map yet"), Reason::kNoMapYet);
  EXPECT_EQ(reason_in("scan is silent: is its driver running? (3.0 s)"), Reason::kSensorSilent);
  EXPECT_EQ(reason_in(""), Reason::kNone);
  EXPECT_EQ(reason_in("no mapping"), Reason::kOther);
}

TEST(Reasons, OfANodeThatDrivesAreInTheTable) {
  for (const auto reason : {FilterReason::kClear, FilterReason::kSlowed, FilterReason::kDeflected,
                            FilterReason::kBackingOut})
    EXPECT_LT(Reason::kOther, reason_in(name(reason))) << name(reason);
  for (const auto reason : {ArbitrationReason::kFollowsSource, ArbitrationReason::kHandover,
                            ArbitrationReason::kUserTakesOver})
    EXPECT_LT(Reason::kOther, reason_in(name(reason))) << name(reason);
  for (const auto status : {PlanStatus::kOptimal, PlanStatus::kAcceptable})
    EXPECT_LT(Reason::kOther, reason_in(name(status))) << name(status);
}

TEST(Reasons, OfEveryTextWithoutAVariablePartAreTheirOwn) {
  for (std::size_t i = static_cast<std::size_t>(Reason::kClear); i < kReasons.size(); ++i)
    if (std::string_view{kReasons[i].text}.find("…") == std::string_view::npos) {
      EXPECT_EQ(reason_in(kReasons[i].text), static_cast<Reason>(i)) << kReasons[i].text;
    }
}

std::string row(const ReasonText& reason) {
  return std::string{"| "} + reason.text + " | " + reason.remedy + " |";
}

TEST(Reasons, AreDocumentedAsInTheTable) {
  std::ifstream file{test::source_path("bringup/ROS2.md")};
  std::vector<std::string> rows, wanted;
  bool in_table = false;
  for (std::string line; std::getline(file, line);) {
    if (line == "| reason | what helps |") in_table = true;
    if (in_table && !line.starts_with("|")) break;
    if (in_table) rows.push_back(line);
  }
  wanted = {"| reason | what helps |", "|---|---|"};
  for (const ReasonText& reason : kReasons)
    if (*reason.remedy != '\0') wanted.push_back(row(reason));
  EXPECT_EQ(rows, wanted);
}

}  // namespace
}  // namespace tandem
