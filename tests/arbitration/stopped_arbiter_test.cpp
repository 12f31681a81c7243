// SPDX-License-Identifier: Apache-2.0
// Tests what moves the robot again after an emergency stop, and what does not.
#include <gtest/gtest.h>

#include "arbitration/arbiter.hpp"

namespace tandem {
namespace {

TEST(Arbiter, ReleasingAnEmergencyStopStartsNothing) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, 0.0}, 0.7);
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  for (double t = 1.0; t < 4.0; t += 0.6) {
    it.on_user({0.5, 0.0}, t);
    EXPECT_EQ(it.decide(t).reason, ArbitrationReason::kLetGoFirst);
    EXPECT_EQ(it.decide(t + 0.2).reason, ArbitrationReason::kLetGoFirst);  // a gap in the stream
    it.on_user({}, t + 0.3);  // nor is a stick that passes its centre
    EXPECT_EQ(it.decide(t + 0.3).reason, ArbitrationReason::kLetGoFirst);
  }
}

TEST(Arbiter, APersonWhoLetGoForASecondDrivesOnAfterAnEmergencyStop) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, 0.0}, 1.0);
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  // a missing input is not a release
  EXPECT_EQ(it.decide(9.0).reason, ArbitrationReason::kLetGoFirst);
  it.on_user({}, 10.0);
  Arbiter silent = it;  // as teleop is once the dead-man button is released
  EXPECT_EQ(silent.decide(10.9).reason, ArbitrationReason::kLetGoFirst);
  EXPECT_EQ(silent.decide(11.1).reason, ArbitrationReason::kUserSilent);
  silent.on_user({0.5, 0.0}, 15.0);
  EXPECT_EQ(silent.decide(15.0).command, (Twist2{0.5, 0.0}));
  it.on_user({}, 11.05);  // a stick that reports that it is at rest
  EXPECT_EQ(it.decide(11.05).reason, ArbitrationReason::kSteerFirst);
  it.on_user({0.5, 0.0}, 11.1);
  EXPECT_EQ(it.decide(11.1).command, (Twist2{0.5, 0.0}));
}

TEST(Arbiter, AStickHeldThroughALostLinkStartsNothingAfterAnEmergencyStop) {
  for (const double silence : {0.2, 1.1, 30.0}) {
    SCOPED_TRACE(silence);
    Arbiter it = arbiter("manual");
    it.on_user({0.5, 0.0}, 1.0);
    it.on_emergency_stop(true);
    it.on_emergency_stop(false);
    ASSERT_TRUE(it.release_emergency_stop());
    EXPECT_EQ(it.decide(1.0 + silence).command, Twist2{});
    it.on_user({0.5, 0.0}, 1.0 + silence);
    EXPECT_EQ(it.decide(1.0 + silence).reason, ArbitrationReason::kLetGoFirst);
  }
}

TEST(Arbiter, ReportsThatNobodySteersIfNobodyEverDidAfterAnEmergencyStop) {
  Arbiter it = arbiter("manual");
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  EXPECT_EQ(it.decide(1.0).reason, ArbitrationReason::kUserSilent);
  it.on_user({0.5, 0.0}, 2.0);
  EXPECT_EQ(it.decide(2.0).reason, ArbitrationReason::kLetGoFirst);
}

TEST(Arbiter, APersonHoldingTheStickAtRestIsNotDrivenByThePlannerAfterAnEmergencyStop) {
  for (const char* policy : {"shared", "blend", "adaptive"}) {
    SCOPED_TRACE(policy);
    Arbiter it = arbiter(policy);
    it.on_user({0.5, 0.0}, 0.0);
    it.on_emergency_stop(true);
    it.on_emergency_stop(false);
    ASSERT_TRUE(it.release_emergency_stop());
    for (double t = 0.1; t < 5.0; t += 0.1) {  // the planner has a goal
      it.on_user({}, t);
      it.on_shared({0.5, 0.0}, t);
      EXPECT_EQ(it.decide(t).command, Twist2{});
    }
    EXPECT_EQ(it.decide(5.0).reason, ArbitrationReason::kSteerFirst);
    it.on_user({0.1, 0.0}, 5.0);
    it.on_shared({0.5, 0.0}, 5.0);
    EXPECT_GT(it.decide(5.0).command.v, 0.0);
    it.on_user({}, 5.05);  // at rest again, the planner drives on
    EXPECT_GT(it.decide(5.05).command.v, 0.0);
  }
}

// Whatever takes over from autonomy.
TEST(Arbiter, SlowSteeringCountsAsSteeringAfterAnEmergencyStop) {
  Arbiter it{{.policy = "manual", .takeover_threshold = 1.0}};
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  for (double t = 1.0; t < 4.0; t += 0.1) {
    it.on_user({0.0, -0.04}, t);
    EXPECT_EQ(it.decide(t).reason, ArbitrationReason::kLetGoFirst);
  }
}

TEST(Arbiter, ALongerUserTimeoutRequiresLettingGoForLongerAfterAnEmergencyStop) {
  Arbiter it{{.policy = "manual", .user_timeout = 3.0}};
  it.on_user({0.5, 0.0}, 1.0);
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  it.on_user({}, 1.1);
  EXPECT_EQ(it.decide(3.9).reason, ArbitrationReason::kLetGoFirst);
  it.on_user({}, 4.2);
  EXPECT_EQ(it.decide(4.2).reason, ArbitrationReason::kSteerFirst);
}

TEST(Arbiter, AStickPushedWhileTheEmergencyStopIsInForceStartsNothing) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, 0.0}, 0.0);
  it.on_emergency_stop(true);
  it.on_user({}, 0.1);
  EXPECT_EQ(it.decide(5.0).reason, ArbitrationReason::kEmergencyStop);  // was let go of
  it.on_user({0.5, 0.0}, 5.1);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  EXPECT_EQ(it.decide(5.1).reason, ArbitrationReason::kLetGoFirst);
}

TEST(Arbiter, AutonomyChosenAfterAnEmergencyStopDrivesOnceTheStickIsLetGo) {
  Arbiter it = arbiter("shared");
  it.on_user({0.5, 0.0}, 1.0);
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  ASSERT_TRUE(it.set_policy(Policy::kAutonomous));
  it.on_nav({0.4, 0.0}, 1.5);
  EXPECT_EQ(it.decide(1.5).reason, ArbitrationReason::kLetGoFirst);
  it.on_user({}, 1.5);
  it.on_nav({0.4, 0.0}, 2.1);
  EXPECT_EQ(it.decide(2.1).reason, ArbitrationReason::kLetGoFirst);
  it.on_nav({0.4, 0.0}, 2.6);
  EXPECT_EQ(it.decide(2.6).source, Source::kNav);
}

TEST(Arbiter, EmergencyStopEndsAutonomy) {
  Arbiter it = arbiter("autonomous");
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  EXPECT_EQ(it.policy(), Policy::kShared);
  it.on_nav({0.5, 0.0}, 1.0);
  it.on_shared({0.5, 0.0}, 1.0);
  EXPECT_EQ(it.decide(1.0).command, Twist2{});
}

TEST(Arbiter, ReleasingAnEmergencyStopStartsNoSource) {
  Arbiter it = arbiter("shared");
  it.on_emergency_stop(true);
  EXPECT_FALSE(it.set_policy(Policy::kAutonomous));
  EXPECT_TRUE(it.set_policy(Policy::kManual));
  it.on_emergency_stop(false);
  EXPECT_FALSE(it.set_policy(Policy::kAutonomous));  // not released yet
  EXPECT_EQ(it.decide(1.0).command, Twist2{});       // nobody is at the stick
  ASSERT_TRUE(it.release_emergency_stop());
  it.on_nav({0.5, 0.0}, 2.0);
  it.on_shared({0.5, 0.0}, 2.0);
  EXPECT_EQ(it.decide(2.0).command, Twist2{});
  EXPECT_TRUE(it.set_policy(Policy::kAutonomous));
  EXPECT_EQ(it.decide(2.0).source, Source::kNav);
}

TEST(Arbiter, EmergencyStopLatchesUntilItIsReleased) {
  Arbiter it = arbiter("manual");
  it.on_emergency_stop(true);
  it.on_user({0.5, 0.0}, 1.0);
  EXPECT_EQ(it.decide(1.0).reason, ArbitrationReason::kEmergencyStop);
  EXPECT_FALSE(it.release_emergency_stop());  // still pressed
  it.on_emergency_stop(false);
  EXPECT_EQ(it.decide(1.0).command, Twist2{});  // `false` alone does not free
  EXPECT_TRUE(it.release_emergency_stop());
  it.on_user({}, 1.02);
  it.on_user({}, 2.05);
  EXPECT_EQ(it.decide(2.05).reason, ArbitrationReason::kSteerFirst);
  it.on_user({0.5, 0.0}, 2.1);
  EXPECT_EQ(it.decide(2.1).command.v, 0.5);
}

}  // namespace
}  // namespace tandem
