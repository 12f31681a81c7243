// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/terminal_keys.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

using Order = TerminalKeys::Order;

TEST(TerminalKeys, HoldAStickWhileTheyRepeat) {
  TerminalKeys keys;
  EXPECT_FALSE(keys.held(0.0));
  EXPECT_EQ(keys.type("i", 0.0), Order::kNone);
  EXPECT_EQ(keys.held(0.5), (TerminalKeys::Stick{0.8, 0.0}));
  for (double t = 0.55; t < 2.0; t += 0.04) (void)keys.type("i", t);
  EXPECT_TRUE(keys.held(1.99 + 0.9 * TerminalKeys::kRepeat));
  EXPECT_FALSE(keys.held(1.99 + 1.1 * TerminalKeys::kRepeat));
}

TEST(TerminalKeys, AKeyTypedOnceIsReleased) {
  TerminalKeys keys;
  (void)keys.type("j", 0.0);
  EXPECT_FALSE(keys.held(1.1 * TerminalKeys::kFirst));
}

TEST(TerminalKeys, AnyOtherKeyStops) {
  for (const char* other : {"k", "y", "\n"}) {
    TerminalKeys keys;
    (void)keys.type("i", 0.0);
    (void)keys.type(other, 0.1);
    EXPECT_FALSE(keys.held(0.1)) << other;
  }
}

TEST(TerminalKeys, ArrowsDriveAndALoneEscapeIsIgnored) {
  TerminalKeys keys;
  (void)keys.type("\x1b[D", 0.0);
  EXPECT_EQ(keys.held(0.1), (TerminalKeys::Stick{0.0, 0.8}));
  (void)keys.type("\x1bOB", 0.2);
  EXPECT_EQ(keys.held(0.3), (TerminalKeys::Stick{-0.8, 0.0}));
  (void)keys.type("\x1b", 0.3);
  (void)keys.type("\x1b[", 0.3);
  EXPECT_FALSE(keys.held(0.3));  // the '[' is any other key
}

TEST(TerminalKeys, ScaleAndKeepDriving) {
  TerminalKeys keys;
  (void)keys.type("i", 0.0);
  (void)keys.type("zzx", 0.1);
  EXPECT_NEAR(keys.held(0.2)->linear, 0.8 * 0.9 * 0.9 * 0.9, 1e-12);
  (void)keys.type(std::string(100, 'q'), 0.2);
  EXPECT_EQ(keys.linear_scale(), 1.0);
  EXPECT_EQ(keys.angular_scale(), 1.0);
}

// Over ssh a connection stalls, its silence releases the key, and then the backlog arrives at once.
// A key that was held all the time must be seen released before the robot drives.
TEST(TerminalKeys, KeysDelayedByAStalledLineHoldNoStickUntilReleased) {
  TerminalKeys keys;
  (void)keys.type("i", 0.0);
  for (double t = 0.04; t < 1.0; t += 0.04) (void)keys.type("i", t);
  for (double t = 1.0; t < 3.0; t += 0.04) (void)keys.type("", t);
  ASSERT_FALSE(keys.held(3.0));
  (void)keys.type(std::string(60, 'i'), 3.0);
  EXPECT_FALSE(keys.held(3.0));
  for (double t = 3.04; t < 5.0; t += 0.04) {
    (void)keys.type("i", t);
    ASSERT_FALSE(keys.held(t)) << t;
  }
  (void)keys.type("", 5.0);
  (void)keys.type("i", 5.2);
  EXPECT_TRUE(keys.held(5.2)) << "a new press";
}

// Then it is this program that comes late.
TEST(TerminalKeys, AreHeldThroughAStallOfTheirReader) {
  TerminalKeys keys;
  (void)keys.type("i", 0.0);
  (void)keys.type(std::string(60, 'i'), 2.0);
  EXPECT_TRUE(keys.held(2.0));
}

TEST(TerminalKeys, OrderTheEmergencyStop) {
  TerminalKeys keys;
  (void)keys.type("i", 0.0);
  EXPECT_EQ(keys.type(" ", 0.1), Order::kEmergencyStop);
  EXPECT_FALSE(keys.held(0.1));
  EXPECT_EQ(keys.type("r", 0.2), Order::kRelease);
}

}  // namespace
}  // namespace tandem
