// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/navigation_check.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

const NavigationState kReady{
    .policy = "autonomous", .method = "goal", .filter_enforces = true, .not_localized = {}};

// What prevents a drive by method `goal`, in words; empty: nothing.
std::string hindrance(const NavigationState& state) {
  const auto found = hindrance_to("goal", state);
  return found ? in_words(*found, "goal", state) : "";
}

NavigationState with(void (*change)(NavigationState&)) {
  NavigationState state = kReady;
  change(state);
  return state;
}

TEST(NavigationCheck, HasNothingAgainstAReadyRobot) { EXPECT_EQ(hindrance(kReady), ""); }

TEST(NavigationCheck, NamesWhatIsMissing) {
  EXPECT_EQ(hindrance(with([](auto& s) { s.emergency_stop = true; })), "emergency stop");
  EXPECT_EQ(hindrance(with([](auto& s) { s.policy = ""; })), "arbitration is silent");
  EXPECT_EQ(hindrance(with([](auto& s) { s.policy = "shared"; })),
            "the policy is shared, not autonomous");
  EXPECT_EQ(hindrance(with([](auto& s) { s.method = ""; })), "the planner is silent");
  EXPECT_EQ(hindrance(with([](auto& s) { s.method = "path"; })),
            "the planner's method is path, not goal");
  EXPECT_EQ(hindrance(with([](auto& s) { s.filter_enforces.reset(); })),
            "the safety filter is silent");
  EXPECT_EQ(hindrance(with([](auto& s) { s.filter_enforces = false; })),
            "the safety filter does not enforce");
  EXPECT_EQ(hindrance(with([](auto& s) { s.not_localized = "not localized: no odom"; })),
            "not localized: no odom");
}

TEST(NavigationCheck, NamesTheEmergencyStopBeforeThePolicyThatItEnded) {
  EXPECT_EQ(hindrance(with([](auto& s) {
              s.emergency_stop = true;
              s.policy = "shared";
            })),
            "emergency stop");
}

}  // namespace
}  // namespace tandem
