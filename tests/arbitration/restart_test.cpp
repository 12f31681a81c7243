// SPDX-License-Identifier: Apache-2.0
// Tests, from the stick to the arbiter, what counts as a release after an emergency stop, whichever
// link in between fails.
#include <gtest/gtest.h>

#include "tandem/arbitration/arbiter.hpp"
#include "tandem/teleop/stick_holder.hpp"
#include "tandem/teleop/teleop.hpp"

namespace tandem {
namespace {

constexpr double kStickPeriod = 0.04;
constexpr Stick kHeld{.linear = 1.0, .deadman = true}, kReleased{};

// An emergency stop that was pressed and released while the stick was held.
class Restart : public ::testing::Test {
 protected:
  Restart() {
    send("page", kHeld, kStickPeriod);
    arbiter_.on_emergency_stop(true);
    arbiter_.on_emergency_stop(false);
    EXPECT_TRUE(arbiter_.release_emergency_stop());
    send("page", kHeld, 0.2);
    EXPECT_EQ(reason_, ArbitrationReason::kLetGoFirst);
  }

  // As teleop's node does on each joy, for `duration` [s].
  void send(const char* sender, const Stick& stick, double duration) {
    for (const double end = t_ + duration; t_ < end;) {
      t_ += kStickPeriod;
      if (holder_.counts(sender, stick.deadman, t_))
        if (const auto intent = teleop_.on_stick(stick, std::nullopt, t_); intent && linked_)
          arbiter_.on_user(intent->twist, t_);
      decide();
    }
  }
  void pass(double duration) {
    for (const double end = t_ + duration; t_ < end; t_ += kStickPeriod) decide();
  }

  bool linked_ = true;  // teleop and arbitration
  bool moved_ = false;
  ArbitrationReason reason_{};

 private:
  void decide() {
    const Decision out = arbiter_.decide(t_);
    moved_ = moved_ || !(out.command == Twist2{});
    reason_ = out.reason;
  }

  Arbiter arbiter_{{.policy = "manual"}};
  Teleop teleop_{{}};
  StickHolder holder_{TeleopParams{}.joy_timeout};
  double t_ = 10.0;
};

TEST_F(Restart, AStickReleasedForASecondDrivesOn) {
  moved_ = false;
  send("page", kReleased, kStickPeriod);
  pass(1.1);
  EXPECT_FALSE(moved_);
  send("page", kHeld, kStickPeriod);
  EXPECT_TRUE(moved_);
}

TEST_F(Restart, AStickHeldWhileItsLinkToTeleopIsLostDoesNot) {
  moved_ = false;
  pass(5.0);
  send("page", kHeld, 5.0);
  EXPECT_FALSE(moved_);
  EXPECT_EQ(reason_, ArbitrationReason::kLetGoFirst);
}

TEST_F(Restart, AStickHeldWhileTheLinkToArbitrationIsLostDoesNot) {
  moved_ = false;
  linked_ = false;
  send("page", kHeld, 5.0);
  linked_ = true;
  send("page", kHeld, 5.0);
  EXPECT_FALSE(moved_);
  EXPECT_EQ(reason_, ArbitrationReason::kLetGoFirst);
}

TEST_F(Restart, AnIdleStickDoesNotReleaseOneWhoseLinkIsLost) {
  moved_ = false;
  send("pad", kReleased, 5.0);
  send("page", kHeld, 5.0);
  EXPECT_FALSE(moved_);
}

TEST_F(Restart, AReleaseWhileTheLinkIsLostCountsFromWhenItIsSeen) {
  moved_ = false;
  pass(5.0);
  send("page", kReleased, 0.2);
  send("page", kHeld, 0.2);
  EXPECT_FALSE(moved_);
  send("page", kReleased, 1.1);
  send("page", kHeld, 0.2);
  EXPECT_TRUE(moved_);
}

}  // namespace
}  // namespace tandem
