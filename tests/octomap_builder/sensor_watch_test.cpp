// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/sensor_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tandem {
namespace {

constexpr double kVoxel = 0.05;
const Eigen::Isometry3d kOnTop = Eigen::Isometry3d::Identity();

// Simulates a scanner in the middle of a room, `half` to each wall [m], at a given position.
RangeReturns in_a_room(double x, double half = 3.0) {
  RangeReturns echoes;
  for (int i = 0; i < 360; ++i) {
    const double angle = std::numbers::pi * i / 180.0, c = std::cos(angle), s = std::sin(angle);
    const double to_x = c == 0.0 ? 1e9 : (std::copysign(half, c) - x) / c;
    const double to_y = s == 0.0 ? 1e9 : std::copysign(half, s) / s;
    echoes.p_SQ.emplace_back(std::min(to_x, to_y) * c, std::min(to_x, to_y) * s, 0.0);
  }
  return echoes;
}

// Only the walls to the left and right.
RangeReturns along_a_corridor() {
  RangeReturns echoes;
  for (const double side : {-1.0, 1.0})
    for (int i = -80; i <= 80; ++i) echoes.p_SQ.emplace_back(0.1 * i, side, 0.0);
  return echoes;
}

class Watched : public testing::Test {
 protected:
  LookUse look(const RangeReturns& seen, double t, double x = 0.0, double theta = 0.0,
               double valid_share = 1.0) {
    const LookUse use =
        watch_.assess({seen, kOnTop, Pose2{x, 0.0, theta}, valid_share}, "9 beams: 9 nan", t);
    if (use != LookUse::kNone) watch_.on_taken(t);
    return use;
  }
  void expect_reason(const std::string& part, double t) {
    EXPECT_NE(watch_.reason(t).find(part), std::string::npos) << watch_.reason(t);
  }

  SensorWatch watch_{"scan", {}, kVoxel};
};

TEST_F(Watched, ASensorThatNeverPublishedIsNotRequired) { EXPECT_EQ(watch_.reason(100.0), ""); }

TEST_F(Watched, ARequiredSensorMustPublish) {
  watch_ = SensorWatch{"scan", {.required_sensors = {"cloud_in", "scan"}}, kVoxel};
  expect_reason("scan is silent", 0.0);
  EXPECT_EQ(look(in_a_room(0.0), 1.0), LookUse::kTake);
  EXPECT_EQ(watch_.reason(1.1), "");
}

TEST_F(Watched, ASensorThatFallsSilentIsNamed) {
  EXPECT_EQ(look(in_a_room(0.0), 1.0), LookUse::kTake);
  EXPECT_EQ(watch_.reason(1.4), "");
  expect_reason("scan is silent", 1.6);
  look(in_a_room(0.0), 2.0);
  EXPECT_EQ(watch_.reason(2.0), "");
}

TEST_F(Watched, ABlindSensorIsNamedWithWhatItSends) {
  look(in_a_room(0.0), 1.0);
  for (double t = 1.1; t < 1.45; t += 0.1)
    EXPECT_EQ(look({}, t, 0.0, 0.0, 0.0), LookUse::kNone) << t;
  EXPECT_EQ(watch_.reason(1.45), "");  // some scans may fail
  look({}, 1.6, 0.0, 0.0, 0.04);
  expect_reason("scan gives no valid range (9 beams: 9 nan)", 1.6);
  expect_reason("no_return", 1.6);
  look(in_a_room(0.0), 1.7, 0.0, 0.0, 0.06);
  EXPECT_EQ(watch_.reason(1.7), "");
}

TEST_F(Watched, ASensorThatWasBlindFromTheStartIsNamed) {
  look({}, 1.0, 0.0, 0.0, 0.0);
  EXPECT_EQ(watch_.reason(1.2), "");
  look({}, 1.6, 0.0, 0.0, 0.0);
  expect_reason("gives no valid range", 1.6);
}

TEST_F(Watched, ReportsWhyItsMessagesAreNotLooks) {
  look(in_a_room(0.0), 1.0);
  watch_.on_trouble("is refused: angle_min must be finite", 1.6);
  expect_reason("scan is refused: angle_min must be finite", 1.6);
  expect_reason("scan is silent", 2.5);
}

TEST_F(Watched, ACloudWithoutPointsIsALook) {
  for (double t = 1.0; t < 5.0; t += 0.1) {
    EXPECT_EQ(look({}, t, t), LookUse::kTake);
    EXPECT_EQ(watch_.reason(t), "");
  }
}

TEST_F(Watched, AFrozenSensorIsNamedOnceItsReturnsShouldHaveMovedByTwoVoxels) {
  const RangeReturns frozen = in_a_room(0.0);
  EXPECT_EQ(look(frozen, 1.0, 0.0), LookUse::kTake);
  for (int i = 1; i <= 9; ++i) {
    EXPECT_EQ(look(frozen, 1.0 + 0.1 * i, 0.01 * i), LookUse::kRepeated) << i;  // not from there
    EXPECT_EQ(watch_.reason(1.0 + 0.1 * i), "") << i;
  }
  look(frozen, 2.0, 0.11);
  expect_reason("scan is frozen", 2.0);
  look(frozen, 2.1, 0.11);
  expect_reason("scan is frozen", 2.1);  // the fault persists while the robot stands
  EXPECT_EQ(look(in_a_room(0.11), 2.2, 0.11), LookUse::kTake);
  EXPECT_EQ(watch_.reason(2.2), "");
}

TEST_F(Watched, AFrozenSensorIsNamedWhileTheRobotTurns) {
  for (int i = 0; i < 10; ++i) look(in_a_room(0.0), 1.0 + 0.1 * i, 0.0, 0.02 * i);
  expect_reason("scan is frozen", 1.9);
}

TEST_F(Watched, ForgettingGivesAFrozenSensorAnotherChance) {
  for (int i = 0; i < 10; ++i) look(in_a_room(0.0), 1.0 + 0.1 * i, 0.05 * i);
  expect_reason("scan is frozen", 1.9);
  watch_.forget();
  EXPECT_EQ(watch_.reason(1.9), "");
}

TEST_F(Watched, AStandingRobotMaySeeTheSameForever) {
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(look(in_a_room(0.0), 1.0 + 0.1 * i, 0.003 * std::sin(i)), LookUse::kTake);
    EXPECT_EQ(watch_.reason(1.0 + 0.1 * i), "");
  }
}

TEST_F(Watched, OneReturnThatDiffersIsEnough) {
  RangeReturns echoes = in_a_room(0.0);
  for (int i = 0; i < 100; ++i) {
    echoes.p_SQ[7].x() = std::nextafter(echoes.p_SQ[7].x(), i % 2 == 0 ? 10.0 : -10.0);
    EXPECT_EQ(look(echoes, 1.0 + 0.1 * i, 0.08 * i), LookUse::kTake);
    EXPECT_EQ(watch_.reason(1.0 + 0.1 * i), "");
  }
}

TEST_F(Watched, AHallWithoutReturnsIsNotFrozen) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(look({{}, {{8.0, 0.0, 0.0}}, {}}, 1.0 + 0.1 * i, 0.08 * i), LookUse::kTake);
    EXPECT_EQ(watch_.reason(1.0 + 0.1 * i), "");
  }
}

// A simulated scanner has no noise, and a long corridor looks the same along its length.
TEST_F(Watched, TwoWallsWithoutAnEndAreNotFrozen) {
  for (int i = 0; i <= 20; ++i) {
    look(along_a_corridor(), 1.0 + 0.1 * i, 0.08 * i);
    EXPECT_EQ(watch_.reason(1.0 + 0.1 * i), "");
  }
  look(along_a_corridor(), 3.1, 2.1);
  expect_reason("frozen", 3.1);  // nobody knows any more
}

TEST_F(Watched, WarnsOfLostBeams) {
  for (int i = 0; i < 100; ++i) look(in_a_room(0.0), 1.0 + 0.1 * i, 0.0, 0.0, 0.98);
  EXPECT_EQ(watch_.warning(), "");
  for (int i = 0; i < 20; ++i) look(in_a_room(0.0), 11.0 + 0.1 * i, 0.0, 0.0, 0.45);
  EXPECT_NE(watch_.warning().find("scan: only 45 %"), std::string::npos) << watch_.warning();
  EXPECT_EQ(watch_.reason(13.0), "");
  look(in_a_room(0.0), 13.1, 0.0, 0.0, 0.9);
  EXPECT_EQ(watch_.warning(), "");
}

TEST_F(Watched, AClockResetMakesNothingFresh) {
  look(in_a_room(0.0), 100.0);
  watch_.on_time_jump(1.0);
  EXPECT_EQ(watch_.reason(1.0), "");
  expect_reason("scan is silent", 1.6);
  look(in_a_room(0.0), 1.7);
  EXPECT_EQ(watch_.reason(1.7), "");
}

}  // namespace
}  // namespace tandem
