// SPDX-License-Identifier: Apache-2.0
// Tests whose command the arbiter passes on.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "arbitration/arbiter.hpp"

namespace tandem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

}  // namespace
}  // namespace tandem
