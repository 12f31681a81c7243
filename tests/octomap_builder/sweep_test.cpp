// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tandem/map/static_map.hpp"
#include "tandem/model/frame_tree.hpp"

namespace tandem {
namespace {

constexpr int kSweepBeams = 720;
constexpr double kPeriod = 0.1, kRange = 8.0;  // [s], [m] of the scanner

// A round room of 4 m radius, centred at the origin.
StaticMap round_room() {
  Grid grid{0.02, {-5.0, -5.0}, 500, 500, std::vector<Cell>(250000, Cell::kFree)};
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix)
      if (grid.center(ix, iy).norm() > 4.0) grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
  return StaticMap{grid};
}

// A scanner on a moving robot, perhaps on a turret: each beam starts from the scanner's pose at the
// beam's time.
struct Sweep {
  Pose2 X_MB;
  Twist2 twist;
  Pose2 X_BS = {};      // at the first beam
  double turret = 0.0;  // [rad/s] turn of the mount
  std::vector<float> ranges = {};

  [[nodiscard]] Pose2 after(double t) const {
    const Pose2 turned{X_BS.x, X_BS.y, X_BS.theta + turret * t};
    return compose(integrate(X_MB, twist, t), turned);
  }
  void turn(const StaticMap& world) {
    for (int i = 0; i < kSweepBeams; ++i) {
      const Pose2 X_MS = after(kPeriod * i / kSweepBeams);
      const double angle = 2.0 * std::numbers::pi * i / kSweepBeams;
      const double d = world.cast_ray(X_MS.position(), X_MS.theta + angle, kRange);
      ranges.push_back(d < kRange ? static_cast<float>(d) : std::numeric_limits<float>::infinity());
    }
  }
  [[nodiscard]] RangeScan scan(double time_increment = kPeriod / kSweepBeams) const {
    return {.angle_min = 0.0,
            .angle_increment = 2.0 * std::numbers::pi / kSweepBeams,
            .range_min = 0.0,
            .range_max = kRange,
            .time_increment = time_increment,
            .ranges = ranges};
  }
  [[nodiscard]] std::vector<Look> looks(double time_increment = kPeriod / kSweepBeams) const {
    return looks_of(scan(time_increment),
                    [&](double t) { return std::optional{in_space(after(t))}; })
        .value();
  }
};

// Largest distance of the range returns from the room's wall [m].
double worst(const std::vector<Look>& looks) {
  double most = 0.0;
  for (const auto& [echoes, X_MS] : looks)
    for (const auto& p_SQ : echoes.p_SQ) {
      const Eigen::Vector3d p_MQ = X_MS * p_SQ;
      most = std::max(most, std::abs(p_MQ.head<2>().norm() - 4.0));
    }
  return most;
}

TEST(Sweep, ReturnsLieOnTheWallHoweverTheRobotAndATurretMove) {
  const StaticMap room = round_room();
  std::mt19937 random{1};
  std::uniform_real_distribution<double> metres(-2.0, 2.0), angle(-3.0, 3.0), speed(-1.0, 1.0);
  double as_one_moment = 0.0;
  for (int n = 0; n < 40; ++n) {
    const Pose2 mount{0.3 * speed(random), 0.3 * speed(random), angle(random)};
    Sweep sweep{{metres(random), metres(random), angle(random)},
                {speed(random), 2.0 * speed(random)},
                mount};
    if (n % 2 == 1) sweep.turret = 2.0 * speed(random);
    sweep.turn(room);
    EXPECT_LT(worst(sweep.looks()), 0.06) << n;  // half a part's turn in 6 m, a cell
    as_one_moment = std::max(as_one_moment, worst(sweep.looks(0.0)));
  }
  EXPECT_GT(as_one_moment, 0.3);  // without the correction the error is large
}

TEST(Sweep, IsOneLookForAStandingRobotAndThePartsContainAllBeams) {
  Sweep sweep{.X_MB = {}, .twist = {}, .ranges = std::vector<float>(kSweepBeams, 2.0F)};
  EXPECT_EQ(sweep.looks().size(), 1U);
  sweep.twist = {0.5, 1.0};
  std::size_t echoes = 0;
  for (const Look& look : sweep.looks()) echoes += look.echoes.p_SQ.size();
  EXPECT_EQ(echoes, sweep.ranges.size());
  EXPECT_EQ(sweep.looks().size(), 10U);
  sweep.twist = {0.0, 1000.0};
  EXPECT_LE(sweep.looks().size(), 100U);
}

TEST(Sweep, OfFewBeamsOrNoneIsSafe) {
  for (const std::size_t beams : {0U, 1U, 2U, 3U}) {
    const Sweep sweep{.X_MB = {}, .twist = {1.0, 3.0}, .ranges = std::vector<float>(beams, 2.0F)};
    std::size_t echoes = 0;
    for (const Look& look : sweep.looks(0.1)) echoes += look.echoes.p_SQ.size();
    EXPECT_EQ(echoes, beams);
  }
}

TEST(Sweep, NeedsThePosesOfItsWholeTime) {
  const std::vector<float> ranges(kSweepBeams, 2.0F);
  const Sweep sweep{.X_MB = {}, .twist = {}, .ranges = ranges};
  const auto until = [](double end) {
    return [end](double t) {
      return t <= end ? std::optional{Eigen::Isometry3d::Identity()} : std::nullopt;
    };
  };
  EXPECT_TRUE(looks_of(sweep.scan(), until(kPeriod)));
  EXPECT_FALSE(looks_of(sweep.scan(), until(0.9 * kPeriod)));
}

}  // namespace
}  // namespace tandem
