// SPDX-License-Identifier: Apache-2.0
// Tests robots that observe the ground with a scanner that has blind sectors.
#include <gtest/gtest.h>

#include <random>

#include "closed_loop/blind_drive.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

// unseen_speed, and what may come to it while the map and odometry are behind [m/s].
constexpr double kSlow = 0.15 + 0.03;

// A world of 16 m, occupied where `inside(x, y)`.
template <class Inside>
Grid world_where(const Inside& inside) {
  Grid grid{0.05, {-8.0, -8.0}, 320, 320, std::vector<Cell>(320 * 320, Cell::kFree)};
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix)
      if (const Eigen::Vector2d p = grid.center(ix, iy); inside(p.x(), p.y()))
        grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
  return grid;
}

Grid room(double half_length, double half_width) {
  return world_where(
      [=](double x, double y) { return std::abs(x) > half_length || std::abs(y) > half_width; });
}

// From the middle of a corridor 1.4 m wide to its closed end, and back.
TEST(UnseenGround, ARobotThatSeesOnlyAheadLeavesADeadEndTheWayItCame) {
  BlindDrive drive({}, room(4.0, 0.7), {-1.0, 0.0, 0.0});
  drive.run({0.8, 0.0}, 8.0);
  ASSERT_GT(drive.X().x, 3.0);
  (void)drive.take_reasons();
  const double began = drive.t();
  drive.run({-0.4, 0.0}, 20.0, [&] { return drive.X().x < -0.4; });
  EXPECT_LT(drive.t() - began, 4.0 / 0.4 + 1.0);
  EXPECT_FALSE(drive.take_reasons().contains(Reason::kUnseenGround));
  // Beside where it stood at first nothing was ever seen.
  drive.run({-0.4, 0.0}, 6.0, [&] { return drive.X().x < -1.0; });
  EXPECT_LT(drive.X().x, -1.0);
  EXPECT_EQ(drive.collisions(), 0U);
}

TEST(UnseenGround, ADeadEndIsLeftSlowlyAfterTheGroundBehindWasForgotten) {
  BlindDrive drive({.coverage_timeout = 5.0}, room(4.0, 0.7), {-1.0, 0.0, 0.0});
  drive.run({0.8, 0.0}, 8.0);
  drive.run({}, 6.0);
  const double x = drive.X().x;
  drive.run({-0.4, 0.0}, 10.0);
  EXPECT_NEAR(drive.X().x, x - 1.5, 0.1);
  EXPECT_LE(drive.max_speed_over_unseen(), kSlow);
  EXPECT_GT(drive.take_reasons()[Reason::kUnseenGround], 200);
}

TEST(UnseenGround, ARobotTurnsAtFullRateInAHallThatItHasDrivenThrough) {
  BlindDrive drive({}, room(5.0, 3.0), {-4.0, 0.0, 0.0});
  drive.run({0.8, 0.0}, 5.5);
  (void)drive.take_reasons();
  double turned = 0.0, last = drive.X().theta;
  drive.run({0.0, 1.0}, 7.0, [&] {
    turned += wrap_angle(drive.X().theta - last);
    last = drive.X().theta;
    return false;
  });
  EXPECT_GT(turned, 6.3);
  EXPECT_FALSE(drive.take_reasons().contains(Reason::kUnseenGround));
}

// An obstacle that the scanner has never seen is half a metre behind the robot.
TEST(UnseenGround, BackwardsIntoWhatWasNeverSeenIsSlow) {
  const auto box = world_where([](double x, double) { return x < -1.0; });
  for (const double unseen_speed : {0.15, 0.08}) {
    BlindDrive drive({.unseen_speed = unseen_speed}, box, {0.0, 0.0, 0.0});
    drive.run({-0.4, 0.0}, 2.5);
    EXPECT_LT(drive.X().x, -1.5 * unseen_speed) << "it may be driven into";
    EXPECT_LE(drive.max_speed_over_unseen(), unseen_speed + 0.01);
    EXPECT_GT(drive.looks_over_unseen(), 5);
    EXPECT_GT(drive.take_reasons()[Reason::kUnseenGround], 20);
  }
}

TEST(UnseenGround, OfSpeedZeroIsNotDrivenInto) {
  const auto box = world_where([](double x, double) { return x < -1.0; });
  BlindDrive drive({.unseen_speed = 0.0}, box, {0.0, 0.0, 0.0});
  drive.run({-0.4, 0.0}, 5.0);
  EXPECT_GT(drive.X().x, -0.06);
  EXPECT_EQ(drive.looks_over_unseen(), 0);
  EXPECT_GT(drive.take_reasons()[Reason::kUnseenGround], 100);
  drive.run({0.8, 0.0}, 3.0);
  EXPECT_GT(drive.X().x, 1.8) << "ahead it sees";
}

// A fork truck's lever: the corners are limited, not v.
TEST(UnseenGround, ATurnAtTheStartSweepsUnseenGroundWithSlowCorners) {
  BlindDrive drive({.scan_angle = 1.0}, room(4.0, 4.0), {0.0, 0.0, 0.0});
  drive.run({0.0, 1.0}, 3.0);
  EXPECT_LE(drive.max_speed_over_unseen(), kSlow);
  EXPECT_GT(drive.looks_over_unseen(), 5);
  EXPECT_GT(drive.X().theta, 0.4);
}

TEST(UnseenGround, AScannerThatSeesAllAroundSlowsNothing) {
  BlindDrive drive({.scan_angle = kAllAround}, room(4.0, 4.0), {-2.0, 0.0, 0.0});
  for (const Twist2& stick : {Twist2{-0.4, 0.3}, Twist2{0.8, 0.0}, Twist2{0.0, 1.0}}) {
    drive.run(stick, 2.0);
    EXPECT_FALSE(drive.take_reasons().contains(Reason::kUnseenGround)) << stick.v;
  }
}

Grid random_room(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-5.0, 5.0), size(0.1, 0.6);
  std::vector<std::array<double, 3>> discs;
  for (int i = 0; i < 14; ++i) {
    discs.push_back({place(random), place(random), size(random)});
    if (std::hypot(discs.back()[0], discs.back()[1]) < 1.5) discs.pop_back();
  }
  return world_where([&](double x, double y) {
    bool occupied = std::max(std::abs(x), std::abs(y)) > 6.0;
    for (const auto& [cx, cy, r] : discs) occupied = occupied || std::hypot(x - cx, y - cy) < r;
    return occupied;
  });
}

// For any stick input and any width of the scanner.
TEST(UnseenGround, IsNeverDrivenOverFasterThanAllowed) {
  int looks = 0;
  for (unsigned seed = 1; seed <= samples(3, 1, 12); ++seed) {
    std::mt19937 random{seed};
    std::uniform_real_distribution<double> share(-1.0, 1.0), angle(0.5, 4.7);
    BlindDrive drive({.scan_angle = angle(random), .coverage_timeout = seed % 2 ? 4.0 : 30.0},
                     random_room(random), {0.0, 0.0, 3.0 * share(random)});
    for (int i = 0; i < 12; ++i) {
      const Twist2 stick{0.8 * share(random), i % 3 ? 1.0 * share(random) : 0.0};
      drive.run(stick, 2.0 + share(random));
    }
    EXPECT_LE(drive.max_speed_over_unseen(), kSlow) << "seed " << seed;
    looks += drive.looks_over_unseen();
  }
  EXPECT_GT(looks, 50) << "else this proves nothing";
}

}  // namespace
}  // namespace tandem::test
