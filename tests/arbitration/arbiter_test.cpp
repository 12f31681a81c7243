// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/arbiter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace tandem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Arbiter arbiter(const char* policy, double handover_time = 0.0) {
  return Arbiter{{.policy = policy, .handover_time = handover_time}};
}

TEST(Arbiter, StandsBeforeAnyCommandHasArrived) {
  const Decision out = arbiter("manual").decide(1.0);
  EXPECT_EQ(out.command, Twist2{});
  EXPECT_EQ(out.source, Source::kNone);
}

TEST(Arbiter, ManualPassesThePersonUnchanged) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, -0.2}, 1.0);
  it.on_shared({0.1, 0.1}, 1.0);
  const Decision out = it.decide(1.01);
  EXPECT_EQ(out.command, (Twist2{0.5, -0.2}));
  EXPECT_EQ(out.source, Source::kUser);
  EXPECT_EQ(out.alpha, 0.0);
}

TEST(Arbiter, SharedPassesThePlannerWhileThePersonHoldsOn) {
  Arbiter it = arbiter("shared");
  it.on_user({0.5, 0.0}, 1.0);
  it.on_shared({0.3, 0.2}, 1.0);
  EXPECT_EQ(it.decide(1.01).command, (Twist2{0.3, 0.2}));
}

TEST(Arbiter, SharedStopsWhenThePersonLetsGo) {
  Arbiter it = arbiter("shared");
  it.on_user({0.5, 0.0}, 1.0);
  it.on_shared({0.3, 0.2}, 1.3);
  const Decision out = it.decide(1.3);
  EXPECT_EQ(out.command, Twist2{});
  EXPECT_EQ(out.reason, ArbitrationReason::kUserSilent);
}

TEST(Arbiter, SharedStopsWhenThePlannerFallsSilent) {
  Arbiter it = arbiter("shared");
  it.on_shared({0.3, 0.2}, 1.0);
  it.on_user({0.5, 0.0}, 1.3);
  const Decision out = it.decide(1.3);
  EXPECT_EQ(out.command, Twist2{});
  EXPECT_EQ(out.reason, ArbitrationReason::kSharedSilent);
  EXPECT_EQ(it.silent_sources(1.3), std::vector<std::string>{"cmd_vel_shared"});
}

TEST(Arbiter, IgnoresACommandThatIsNotFinite) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, 0.0}, 1.0);
  it.on_user({kNaN, 0.0}, 1.1);
  EXPECT_EQ(it.decide(1.1).command.v, 0.5);
  EXPECT_EQ(it.decide(1.2).reason, ArbitrationReason::kUserSilent);  // the NaN did not refresh
}

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

TEST(Arbiter, AutonomyYieldsToThePersonsStick) {
  Arbiter it = arbiter("autonomous");
  it.on_nav({0.4, 0.0}, 1.0);
  it.on_shared({0.2, 0.0}, 1.0);
  EXPECT_EQ(it.decide(1.0).source, Source::kNav);
  it.on_user({0.0, 0.3}, 1.05);
  EXPECT_EQ(it.decide(1.05).reason, ArbitrationReason::kUserTakesOver);
  it.on_user({0.0, 0.0}, 1.1);  // at rest: no wish
  EXPECT_EQ(it.decide(1.1).source, Source::kNav);
}

TEST(Arbiter, AutonomyFallsBackToThePlannersGoal) {
  Arbiter it = arbiter("autonomous");
  it.on_nav({0.4, 0.0}, 1.0);
  it.on_shared({0.2, 0.0}, 1.6);
  EXPECT_EQ(it.decide(1.6).source, Source::kShared);
}

TEST(Arbiter, ChangeOfAuthorityRampsUpAndAStopDoesNotWait) {
  Arbiter it = arbiter("manual", 0.2);
  it.on_user({0.0, 0.0}, 1.0);
  EXPECT_EQ(it.decide(1.0).command.v, 0.0);
  ASSERT_TRUE(it.set_policy(Policy::kShared));
  it.on_shared({0.8, 0.0}, 1.0);
  EXPECT_NEAR(it.decide(1.0).command.v, 0.0, 1e-12);
  EXPECT_NEAR(it.decide(1.1).command.v, 0.4, 1e-12);
  EXPECT_EQ(it.decide(1.1).reason, ArbitrationReason::kHandover);
  it.on_emergency_stop(true);
  EXPECT_EQ(it.decide(1.11).command, Twist2{});
}

TEST(Arbiter, ChangeOfAuthorityDoesNotDelayBraking) {
  Arbiter it = arbiter("autonomous", 0.3);
  it.on_nav({0.8, 0.5}, 1.0);
  ASSERT_EQ(it.decide(1.0).command.v, 0.8);
  it.on_user({0.1, 0.0}, 1.05);
  EXPECT_EQ(it.decide(1.05).command, (Twist2{0.1, 0.0}));
  it.on_user({-0.4, 0.0}, 1.1);
  EXPECT_EQ(it.decide(1.1).command.v, -0.4);  // the same source: no handover
}

// The stick is pulled back and released in turn, so that the person takes over and autonomy, which
// has stopped meanwhile, resumes with each command.
TEST(Arbiter, RepeatedTakeoversDoNotResumeTheOldCommand) {
  for (const Twist2& rest : {Twist2{}, Twist2{-0.049, 0.0}}) {
    Arbiter it = arbiter("autonomous", 0.3);
    it.on_nav({0.8, 0.0}, 1.0);
    ASSERT_EQ(it.decide(1.0).command.v, 0.8);
    for (int i = 1; i < 100; ++i) {
      const double t = 1.0 + 0.05 * i;
      it.on_nav({}, t);
      it.on_user(i % 2 == 1 ? Twist2{-0.4, 0.0} : rest, t);
      EXPECT_LE(it.decide(t).command.v, 0.0) << t;
      EXPECT_GE(it.decide(t).command.v, -0.4) << t;
    }
  }
}

// Feeds random commands, gaps and policies into an arbiter and into one without ramps.
class WithAndWithoutRamp {
 public:
  void step() {
    t_ += any_time_(random_);
    if (random_() % 3 != 0) tell(&Arbiter::on_user);
    if (random_() % 3 != 0) tell(&Arbiter::on_shared);
    if (random_() % 3 != 0) tell(&Arbiter::on_nav);
    if (random_() % 9 == 0) clearance_ = any_(random_);
    for (Arbiter* it : {&ramped_, &plain_}) it->on_clearance(clearance_, t_);
    if (random_() % 20 == 0) {
      const auto policy = static_cast<Policy>(random_() % policies().size());
      ASSERT_EQ(ramped_.set_policy(policy), plain_.set_policy(policy));
    }
    out = ramped_.decide(t_);
    const Decision before = std::exchange(chosen, plain_.decide(t_));
    if (chosen.source != before.source) since_ = t_;
  }
  [[nodiscard]] bool handed_over() const { return t_ >= since_ + kHandover; }

  Decision out, chosen;

 private:
  static constexpr double kHandover = 0.3;

  void tell(void (Arbiter::*hear)(const Twist2&, double)) {
    const Twist2 twist{component(), component()};
    (ramped_.*hear)(twist, t_);
    (plain_.*hear)(twist, t_);
  }
  double component() {
    const auto kind = random_() % 8;
    if (kind == 0) return 0.0;
    if (kind == 1) return any_(random_) < 0.0 ? -1.7e308 : 1.7e308;
    return any_(random_);
  }

  std::mt19937 random_{1};
  std::uniform_real_distribution<double> any_{-1.0, 1.0}, any_time_{0.0, 0.06};
  Arbiter ramped_ = arbiter("autonomous", kHandover), plain_ = arbiter("autonomous");
  double t_ = 1.0, since_ = 0.0, clearance_ = 5.0;
};

TEST(Arbiter, OutputIsFiniteAndNeverFasterThanTheChosenCommandWhateverSourcesDo) {
  const auto within = [](double out, double chosen) {
    return out * chosen >= 0.0 && std::abs(out) <= std::abs(chosen);
  };
  WithAndWithoutRamp both;
  for (int i = 0; i < 200000; ++i) {
    both.step();
    const Twist2 &out = both.out.command, &chosen = both.chosen.command;
    ASSERT_TRUE(is_finite(out) && is_finite(chosen)) << chosen.v << ", " << chosen.w;
    ASSERT_EQ(both.out.source, both.chosen.source);
    ASSERT_TRUE(within(out.v, chosen.v)) << out.v << " of " << chosen.v;
    ASSERT_TRUE(within(out.w, chosen.w)) << out.w << " of " << chosen.w;
    if (both.handed_over()) {
      ASSERT_EQ(out, chosen);
    }
  }
}

TEST(Arbiter, BlendsHugeCommandsToAFiniteOne) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  for (const char* policy : {"blend", "adaptive"}) {
    Arbiter it = arbiter(policy);
    for (double t = 1.0; t < 3.0; t += 0.05) {
      it.on_user({kHuge, -kHuge}, t);
      it.on_shared({-kHuge, kHuge}, t);
      it.on_clearance(t < 2.0 ? 5.0 : -kHuge, t);
      const Decision out = it.decide(t);
      ASSERT_TRUE(is_finite(out.command)) << policy << " at " << t;
      ASSERT_GE(out.alpha, 0.0);
      ASSERT_LE(out.alpha, 1.0);
      ASSERT_GE(out.performance, 0.0);
      ASSERT_LE(out.performance, 1.0);
    }
  }
}

TEST(Arbiter, BlendGivesThePlannerMoreNearObstacles) {
  Arbiter it = arbiter("blend");
  double far = 0.0, near = 0.0;
  for (double t = 1.0; t < 3.0; t += 0.05) {
    it.on_user({0.5, 0.0}, t);
    it.on_shared({0.45, 0.0}, t);
    it.on_clearance(5.0, t);
    far = it.decide(t).alpha;
  }
  for (double t = 3.0; t < 5.0; t += 0.05) {
    it.on_user({0.5, 0.0}, t);
    it.on_shared({0.45, 0.0}, t);
    it.on_clearance(0.0, t);
    near = it.decide(t).alpha;
  }
  EXPECT_NEAR(far, 0.1, 1e-9);
  EXPECT_NEAR(near, 1.0, 1e-9);
}

TEST(Arbiter, BlendChangesAuthorityNoFasterThanItsRate) {
  Arbiter it{{.policy = "blend", .handover_time = 0.0, .blend = {.rate = 2.0}}};
  double last = 0.0;
  for (double t = 1.0; t < 2.0; t += 0.05) {
    it.on_user({0.8, 0.0}, t);
    it.on_shared({-0.4, 1.0}, t);
    const double alpha = it.decide(t).alpha;
    if (t > 1.0) {
      EXPECT_LE(alpha - last, 2.0 * 0.05 + 1e-9);
    }
    last = alpha;
  }
  EXPECT_EQ(last, 1.0);
}

TEST(Arbiter, KeepsRunningAfterABlendParameterChange) {
  Arbiter it{{.policy = "blend", .handover_time = 0.0}};
  EXPECT_THROW(it.set_blend({.rate = 0.0}), std::invalid_argument);
  it.set_blend({.min = 0.3});
  double alpha = 0.0;
  for (double t = 1.0; t < 2.0; t += 0.05) {
    it.on_user({0.5, 0.0}, t);
    it.on_shared({0.5, 0.0}, t);
    it.on_clearance(9.0, t);
    alpha = it.decide(t).alpha;
  }
  EXPECT_NEAR(alpha, 0.3, 1e-9);
  EXPECT_EQ(it.policy(), Policy::kBlend);
}

TEST(Arbiter, RefusesAnUnknownPolicy) {
  EXPECT_THROW(arbiter("anarchy"), std::invalid_argument);
  EXPECT_THROW((void)policy_from(""), std::invalid_argument);
}

TEST(Arbiter, ACommandFromBeforeAClockResetIsOld) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, 0.0}, 60.0);
  EXPECT_EQ(it.decide(60.0).command.v, 0.5);
  it.on_time_jump(0.1);
  EXPECT_EQ(it.decide(0.1).reason, ArbitrationReason::kUserSilent);
  EXPECT_EQ(it.decide(60.05).reason, ArbitrationReason::kUserSilent);
  it.on_user({0.5, 0.0}, 60.1);
  EXPECT_EQ(it.decide(60.1).command.v, 0.5);
}

TEST(Arbiter, AClockResetDoesNotCountAsLettingGo) {
  Arbiter it = arbiter("manual");
  it.on_user({0.5, 0.0}, 60.0);
  it.on_emergency_stop(true);
  it.on_emergency_stop(false);
  ASSERT_TRUE(it.release_emergency_stop());
  EXPECT_EQ(it.decide(60.0).reason, ArbitrationReason::kLetGoFirst);
  it.on_time_jump(0.0);
  EXPECT_EQ(it.decide(0.0).reason, ArbitrationReason::kLetGoFirst);
  it.on_user({0.5, 0.0}, 0.1);
  EXPECT_EQ(it.decide(0.1).reason, ArbitrationReason::kLetGoFirst);
  it.on_user({0.0, 0.0}, 1.2);
  EXPECT_EQ(it.decide(1.2).reason, ArbitrationReason::kLetGoFirst);
  it.on_user({0.0, 0.0}, 2.3);
  EXPECT_EQ(it.decide(2.3).reason, ArbitrationReason::kSteerFirst);
}

TEST(Arbiter, ARampEndsAtAClockReset) {
  Arbiter it = arbiter("autonomous", 0.4);
  it.on_nav({0.2, 0.0}, 60.0);
  EXPECT_EQ(it.decide(60.0).command.v, 0.2);
  it.on_user({0.6, 0.0}, 60.1);
  EXPECT_EQ(it.decide(60.1).command.v, 0.2);
  it.on_time_jump(0.0);
  it.on_user({0.6, 0.0}, 0.0);
  EXPECT_EQ(it.decide(0.0).command.v, 0.6);
}

// Drives for the planner at time t [s].
void drive(Arbiter& it, double t) {
  it.on_user({0.5, 0.0}, t);
  it.on_shared({0.3, 0.0}, t);
}

std::string why(Arbiter& it, double t) { return it.why(it.decide(t), t); }

TEST(Arbiter, ReportsWhatHindersPlannerOrFilterWhileItsOwnInputsArrive) {
  Arbiter it = arbiter("shared");
  drive(it, 1.0);
  EXPECT_EQ(why(it, 1.0), "follows the source");
  it.on_planner("obstacles are silent", 1.0);
  EXPECT_EQ(why(it, 1.0), "planner: obstacles are silent");
  it.on_filter("not localized", 1.0);
  EXPECT_EQ(why(it, 1.0), "safety filter: not localized");
  it.on_filter("", 1.05);
  it.on_planner("", 1.05);
  EXPECT_EQ(why(it, 1.05), "follows the source");
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
  EXPECT_EQ(why(it, 1.6), "follows the source");
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
  EXPECT_EQ(why(it, 1.0), "follows the source");
}

}  // namespace
}  // namespace tandem
