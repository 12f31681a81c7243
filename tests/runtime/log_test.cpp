// SPDX-License-Identifier: Apache-2.0
// Tests a logger without a node, and which of a node's states are logged.
#include "tandem/runtime/log.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tandem {
namespace {

namespace rt = runtime;

TEST(Logger, CallsASinkUntilItIsTakenAway) {
  rt::Logger log{"drain"};
  int lines = 0;
  log.set_sink([&](const rt::LogLine&) { ++lines; });
  log.info("counted");
  log.set_sink({});
  log.info("not counted");
  EXPECT_EQ(lines, 1);
}

class StatesInALog : public ::testing::Test {
 protected:
  StatesInALog() {
    log_.set_clock([this] { return now_; });
    log_.set_sink([this](const rt::LogLine& line) {
      lines_.push_back(line.text);
      levels_.push_back(line.level);
    });
  }

  void enter(const std::string& state) { states_.enter(rt::LogLevel::kInfo, state, state); }

  using Lines = std::vector<std::string>;

  double now_ = 0.0;  // [s]
  rt::Logger log_{"robot"};
  rt::StateLog states_{log_, 1.0};
  Lines lines_;
  std::vector<rt::LogLevel> levels_;
};

TEST_F(StatesInALog, AreLoggedWhenTheyAreEnteredAndNotWhileTheyLast) {
  for (; now_ < 5.0; now_ += 0.1) enter("no map");
  enter("no odometry");
  EXPECT_EQ(lines_, (Lines{"no map", "no odometry"}));
}

TEST_F(StatesInALog, AreLoggedAfterThePeriodIfTheyReturnedWithinItAndLast) {
  enter("no odometry");
  states_.leave();
  for (now_ = 0.5; now_ < 0.95; now_ += 0.1) enter("no odometry");
  EXPECT_EQ(lines_, Lines{"no odometry"});
  for (now_ = 1.0; now_ < 5.0; now_ += 0.1) enter("no odometry");
  EXPECT_EQ(lines_, (Lines{"no odometry", "no odometry"})) << "and no more";
}

TEST_F(StatesInALog, AreLoggedWithinALongPeriodOnceTheyHaveSettled) {
  rt::StateLog states{log_, 10.0};
  const auto enter = [&](const char* state) { states.enter(rt::LogLevel::kInfo, state, state); };
  enter("in charge");
  enter("silent");
  for (now_ = 2.0; now_ < 2.95; now_ += 0.1) enter("in charge");
  EXPECT_EQ(lines_, (Lines{"in charge", "silent"}));
  now_ = 3.05;
  enter("in charge");
  EXPECT_EQ(lines_, (Lines{"in charge", "silent", "in charge"}));
}

TEST_F(StatesInALog, ThatAlternateAreCountedAndTheLastOneIsLogged) {
  for (int i = 0; i < 10; ++i, now_ += 0.05) {
    enter("in charge");
    enter("silent");
  }
  EXPECT_EQ(lines_, (Lines{"in charge", "silent"}));
  now_ = 1.0;
  enter("silent");  // still the tenth time
  EXPECT_EQ(lines_.back(), "silent (and 8 times before)");
  enter("in charge");
  EXPECT_EQ(lines_.back(), "in charge (and 9 times before)");
}

TEST_F(StatesInALog, AreTheSameIfTheirKeysAre) {
  states_.enter(rt::LogLevel::kWarn, "dropped", "dropped (1)");
  states_.enter(rt::LogLevel::kWarn, "dropped", "dropped (2)");
  EXPECT_EQ(lines_, Lines{"dropped (1)"});
}

TEST_F(StatesInALog, ForWhichAnInputIsMissingAreWarningsOnceTheNodeHasStarted) {
  states_.enter_missing("no map");
  now_ = 10.0;
  states_.enter_missing("no odometry");
  EXPECT_EQ(levels_, (std::vector{rt::LogLevel::kInfo, rt::LogLevel::kWarn}));
}

TEST_F(StatesInALog, BelowItsLevelAreNotLogged) {
  log_.set_level(rt::LogLevel::kError);
  enter("no map");
  log_.set_level(rt::LogLevel::kInfo);
  enter("no map");
  EXPECT_TRUE(lines_.empty());
  enter("no odometry");
  EXPECT_EQ(lines_, Lines{"no odometry"});
}

}  // namespace
}  // namespace tandem
