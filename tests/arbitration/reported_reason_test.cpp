// SPDX-License-Identifier: Apache-2.0
// Tests which of several reasons for standing the arbiter reports.
#include <gtest/gtest.h>

#include "arbitration/arbiter.hpp"

namespace tandem {
namespace {

// Drives for the planner at time t [s].
void drive(Arbiter& it, double t) {
  it.on_user({0.5, 0.0}, t);
  it.on_shared({0.3, 0.0}, t);
}

std::string why(Arbiter& it, double t) { return it.why(it.decide(t), t); }

TEST(Arbiter, ReportsWhatHindersPlannerOrFilterWhileItsOwnInputsArrive) {
  Arbiter it = arbiter("shared");
  drive(it, 1.0);
  EXPECT_EQ(why(it, 1.0), "in charge");
  it.on_planner("obstacles are silent", 1.0);
  EXPECT_EQ(why(it, 1.0), "planner: obstacles are silent");
  it.on_filter("not localized", 1.0);
  EXPECT_EQ(why(it, 1.0), "safety filter: not localized");
  it.on_filter("", 1.05);
  it.on_planner("", 1.05);
  EXPECT_EQ(why(it, 1.05), "in charge");
}

TEST(Arbiter, ReportsItsOwnStopBeforeOthersExceptThatNobodySteers) {
  Arbiter it = arbiter("shared");
  drive(it, 1.0);
  it.on_planner("leader_pose is silent", 1.2);
  EXPECT_EQ(why(it, 1.2), "cmd_vel_user is silent");
  it.on_filter("no map", 1.2);
  EXPECT_EQ(why(it, 1.2), "safety filter: no map");
  it.on_user({0.5, 0.0}, 1.2);
  EXPECT_EQ(why(it, 1.2), "cmd_vel_shared is silent");
  it.on_emergency_stop(true);
  EXPECT_EQ(why(it, 1.2), "emergency stop");
}

TEST(Arbiter, ReportsASilentFilterAndForgetsASilentPlanner) {
  Arbiter it = arbiter("shared");
  it.on_filter("", 1.0);
  it.on_planner("timeout", 1.0);
  drive(it, 1.6);
  EXPECT_EQ(why(it, 1.6), "safety filter is silent");
  it.on_filter("", 1.6);
  EXPECT_EQ(why(it, 1.6), "in charge");
}

TEST(Arbiter, ReportsWhyThePersonsStickMovesNothing) {
  Arbiter it = arbiter("manual");
  it.on_stick("stick is not at rest", 1.0);
  EXPECT_EQ(why(it, 1.2), "stick is not at rest");
  it.on_filter("no map", 1.2);
  EXPECT_EQ(why(it, 1.2), "stick is not at rest") << "the first cause";
  it.on_user({0.3, 0.0}, 1.2);
  EXPECT_EQ(why(it, 1.2), "safety filter: no map") << "another one drives";
  it.on_filter("", 1.2);
  EXPECT_EQ(why(it, 1.6), "cmd_vel_user is silent") << "nobody holds it any more";
  it.on_stick("stick is not at rest", 1.6);
  it.on_stick("", 1.7);
  EXPECT_EQ(why(it, 1.7), "cmd_vel_user is silent");
}

TEST(Arbiter, DoesNotReportPlannerTroubleWhileThePersonDrives) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, 0.0}, 1.0);
  it.on_planner("no goal_pose yet", 1.0);
  EXPECT_EQ(why(it, 1.0), "in charge");
}

}  // namespace
}  // namespace tandem
