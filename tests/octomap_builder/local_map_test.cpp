// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/local_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "support/instrumented.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/octomap_builder/pose_history.hpp"

namespace tandem {
namespace {

constexpr double kHeight = 0.3;  // of the sensor [m]
constexpr int kBeams = 720;

Eigen::Isometry3d at(const Pose2& X, double z = kHeight) {
  return Eigen::Translation3d(X.x, X.y, z) * Eigen::AngleAxisd(X.theta, Eigen::Vector3d::UnitZ());
}

StaticMap random_world(std::mt19937& random) {
  Grid grid{0.05, {-5.0, -5.0}, 200, 200, std::vector<Cell>(40000, Cell::kFree)};
  std::uniform_int_distribution<int> place(0, 190), size(1, 8);
  for (int n = 0; n < 40; ++n) {
    const int x0 = place(random), y0 = place(random), w = size(random), h = size(random);
    // keeps the robot's position free
    if (std::abs(x0 - 100) < 12 && std::abs(y0 - 100) < 12) continue;
    for (int iy = y0; iy < y0 + h; ++iy)
      for (int ix = x0; ix < x0 + w; ++ix) grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
  }
  return StaticMap{grid};
}

std::vector<float> look(const StaticMap& world, const Pose2& X, double range) {
  std::vector<float> ranges;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kBeams;
    const double d = world.cast_ray(X.position(), X.theta + angle, range);
    ranges.push_back(d < range ? static_cast<float>(d) : std::numeric_limits<float>::infinity());
  }
  return ranges;
}

RangeReturns echoes(const StaticMap& world, const Pose2& X, double range = 6.0) {
  const auto ranges = look(world, X, range);
  return range_returns_of(RangeScan{.angle_min = 0.0,
                                    .angle_increment = 2.0 * std::numbers::pi / kBeams,
                                    .range_min = 0.0,
                                    .range_max = range,
                                    .ranges = ranges});
}

RangeReturns one_echo(double x, double y, double z = 0.0) { return {{{x, y, z}}, {}, {}}; }

bool is_occupied(const LocalMap& map, const Eigen::Vector3d& p) {
  const auto* node = map.tree().search(p.x(), p.y(), p.z());
  return node != nullptr && map.tree().isNodeOccupied(node);
}
bool is_free(const LocalMap& map, const Eigen::Vector3d& p) {
  const auto* node = map.tree().search(p.x(), p.y(), p.z());
  return node != nullptr && !map.tree().isNodeOccupied(node);
}

void insert(LocalMap& map, const RangeReturns& echoes, const Pose2& X, double t) {
  const Look look{echoes, at(X)};
  ASSERT_TRUE(map.insert({&look, 1}, t));
}

// A way through random worlds, a look from each place, other things there each time.
TEST(LocalMap, EveryReturnIsAnObstacleWhateverWasThereBefore) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> metres(-0.4, 0.4), angle(-3.0, 3.0);
  LocalMap map({});
  for (int n = 0; n < 30; ++n) {
    const StaticMap world = random_world(random);
    const Pose2 X{metres(random), metres(random), angle(random)};
    const RangeReturns seen = echoes(world, X);
    ASSERT_GT(seen.p_SQ.size(), 50U);
    insert(map, seen, X, 0.1 * n);
    for (const auto& p_SQ : seen.p_SQ) {
      const Eigen::Vector3d p_MQ = at(X) * (p_SQ * (1.0 + 0.001 / p_SQ.norm()));
      ASSERT_TRUE(is_occupied(map, p_MQ)) << n << ": " << p_MQ.transpose();
    }
  }
}

// The map's slice, as the filter and the extractor get it, has the world's cells where range
// returns came from, and none where the world is free by more than the rounding of a range.
TEST(LocalMap, ShowsTheObservedWorld) {
  std::mt19937 random{2};
  for (int n = 0; n < 8; ++n) {
    const StaticMap world = random_world(random);
    LocalMap map({});
    const Pose2 X{0.013, 0.021, 0.3};
    for (int i = 0; i < 3; ++i) insert(map, echoes(world, X), X, 0.1 * i);
    const Grid grid = slice(map.tree(), {});
    int occupied = 0;
    for (int iy = 0; iy < grid.height; ++iy)
      for (int ix = 0; ix < grid.width; ++ix) {
        if (grid.at(ix, iy) != Cell::kOccupied) continue;
        ++occupied;
        EXPECT_LT(world.distance(grid.center(ix, iy)), 0.05) << grid.center(ix, iy).transpose();
      }
    EXPECT_GT(occupied, 20);
    EXPECT_TRUE(is_free(map, {X.x, X.y, kHeight}));
  }
}

TEST(LocalMap, WhatIsSeenThroughIsCleared) {
  LocalMap map({});
  const RangeReturns pole = one_echo(2.0, 0.0), beyond{{}, {{5.0, 0.0, 0.0}}, {}};
  for (int i = 0; i < 50; ++i) insert(map, pole, {}, 0.1 * i);
  ASSERT_TRUE(is_occupied(map, {2.01, 0.0, kHeight}));
  int looks = 0;
  while (is_occupied(map, {2.01, 0.0, kHeight})) {
    insert(map, beyond, {}, 5.0 + 0.1 * looks);
    ASSERT_LT(++looks, 15);
  }
  EXPECT_GT(looks, 2);  // one miss does not erase what was seen many times
  // A single false range return in known free space is erased by the next scan.
  for (int i = 0; i < 20; ++i) insert(map, beyond, {}, 10.0);
  insert(map, pole, {}, 10.0);
  EXPECT_TRUE(is_occupied(map, {2.01, 0.0, kHeight}));
  insert(map, beyond, {}, 10.1);
  EXPECT_TRUE(is_free(map, {2.01, 0.0, kHeight}));
}

TEST(LocalMap, ForgetsWhatItHasNotSeenForTheTimeOfDecay) {
  LocalMap map({.decay = 2.0}), keeps({.decay = 0.0});
  const RangeReturns other = one_echo(0.0, 3.0);
  for (LocalMap* m : {&map, &keeps}) {
    insert(*m, one_echo(2.0, 0.0), {}, 1.0);
    insert(*m, other, {}, 2.9);
    EXPECT_TRUE(is_occupied(*m, {2.01, 0.0, kHeight}));
    insert(*m, other, {}, 3.1);
    EXPECT_TRUE(is_occupied(*m, {0.01, 3.01, kHeight}));
  }
  EXPECT_FALSE(is_occupied(map, {2.01, 0.0, kHeight}));
  EXPECT_TRUE(is_occupied(keeps, {2.01, 0.0, kHeight}));
}

TEST(LocalMap, SeeingAnObstacleAgainKeepsIt) {
  LocalMap map({.decay = 2.0});
  for (int i = 0; i < 100; ++i) {
    insert(map, one_echo(2.0, 0.0), {}, 0.1 * i);
    ASSERT_TRUE(is_occupied(map, {2.01, 0.0, kHeight}));
  }
}

TEST(LocalMap, RangesAndHeightsHaveTheirLimits) {
  LocalMap map({.min_range = 0.5, .max_range = 4.0});
  insert(map, one_echo(0.4, 0.0), {}, 0.0);        // the robot's own body
  insert(map, one_echo(0.0, 5.0), {}, 0.0);        // too far to mark, near enough to clear
  insert(map, one_echo(-2.0, 0.0, 2.0), {}, 0.0);  // a beam of the ceiling
  EXPECT_FALSE(is_occupied(map, {0.41, 0.0, kHeight}));
  EXPECT_FALSE(is_free(map, {0.2, 0.0, kHeight}));
  EXPECT_FALSE(is_occupied(map, {0.0, 5.01, kHeight}));
  EXPECT_TRUE(is_free(map, {0.01, 3.9, kHeight}));
  EXPECT_FALSE(is_free(map, {0.01, 4.2, kHeight}));
  EXPECT_FALSE(is_occupied(map, {-2.0, 0.0, 2.3}));
  EXPECT_TRUE(is_free(map, {-0.5, 0.0, kHeight + 0.5}));
}

TEST(LocalMap, RefusesLooksWithoutAValidPose) {
  LocalMap map({});
  Eigen::Isometry3d X = at({});
  X.translation().x() = std::nan("");
  for (const Eigen::Isometry3d& X_MS : {X, at({1e6, 0.0, 0.0})}) {
    const std::vector<Look> looks{{one_echo(1.0, 0.0), at({})}, {one_echo(1.0, 0.0), X_MS}};
    EXPECT_FALSE(map.insert(looks, 0.0));
  }
  EXPECT_EQ(map.tree().size(), 0U);
}

// One kilometre of new surroundings.
TEST(LocalMap, MemoryIsThatOfItsWindowHoweverFarTheRobotDrives) {
  const LocalMapParams params{.window = 8.0, .max_range = 6.0, .decay = 5.0};
  LocalMap map(params);
  std::mt19937 random{3};
  std::uniform_real_distribution<double> range(1.0, 8.0);
  std::size_t most_early = 0, most = 0;
  constexpr int kScans = static_cast<int>(test::samples(500, 120));
  for (int n = 0; n < kScans; ++n) {
    RangeReturns seen;
    for (int i = 0; i < 60; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 60, r = range(random);
      seen.p_SQ.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.0);
    }
    insert(map, seen, {500.0 - 2.0 * (kScans - n), 0.2 * std::sin(n), 0.1 * n}, 2.0 * n);
    (n < 50 ? most_early : most) = std::max(n < 50 ? most_early : most, map.tree().size());
  }
  EXPECT_LT(static_cast<double>(most), 1.2 * static_cast<double>(most_early));
  for (auto leaf = map.tree().begin_leafs(); leaf != map.tree().end_leafs(); ++leaf) {
    EXPECT_LT(std::abs(leaf.getX() - 498.0), 6.1);
    EXPECT_LT(std::abs(leaf.getY()), 6.1);
  }
}

TEST(LocalMap, StartsOverWhenTheRobotIsMovedElsewhere) {
  LocalMap map({});
  insert(map, one_echo(2.0, 0.0), {}, 0.0);
  insert(map, one_echo(2.0, 0.0), {300.0, 0.0, 0.0}, 0.1);
  EXPECT_TRUE(is_occupied(map, {302.01, 0.0, kHeight}));
  const Grid grid = slice(map.tree(), {});
  EXPECT_LT(grid.width, 50);  // nothing is left of the first place
}

TEST(LocalMap, LearnsAgainWhatHadLeftItsWindow) {
  LocalMap map({.window = 8.0});
  const auto covered = [&](double x) { return is_free(map, {x, 0.0, kHeight}); };
  for (int i = 0; i < 20; ++i) insert(map, one_echo(-3.9, 0.0), {}, 0.1 * i);
  insert(map, one_echo(1.0, 0.0), {2.5, 0.0, 0.0}, 2.0);  // the window is now -2 … 6 m
  for (double x = -3.8; x < -2.1; x += 0.05) EXPECT_FALSE(covered(x)) << x;
  insert(map, one_echo(-3.9, 0.0), {}, 2.1);
  for (double x = -3.8; x < -0.1; x += 0.05) EXPECT_TRUE(covered(x)) << x;
}

TEST(LocalMap, ForgetsAllWhenToldTo) {
  LocalMap map({.decay = 1.0});
  insert(map, one_echo(2.0, 0.0), {}, 0.0);
  map.clear();
  EXPECT_EQ(map.tree().size(), 0U);
  insert(map, one_echo(0.0, 2.0), {}, 5.0);
  EXPECT_FALSE(is_occupied(map, {2.01, 0.0, kHeight}));
  EXPECT_TRUE(is_occupied(map, {0.01, 2.01, kHeight}));
}

bool is_known(const LocalMap& map, const Eigen::Vector3d& p) {
  return map.tree().search(p.x(), p.y(), p.z()) != nullptr;
}

TEST(LocalMap, AnObstacleThatDecaysIsUnknownAndNotFree) {
  LocalMap map({.decay = 2.0});
  insert(map, one_echo(2.0, 0.0), {}, 1.0);
  insert(map, one_echo(0.0, 3.0), {}, 3.1);
  EXPECT_FALSE(is_known(map, {2.01, 0.0, kHeight}));
}

TEST(LocalMap, FreeGroundIsUnknownOnceNoBeamHasCoveredItForTheTimeout) {
  LocalMap map({.coverage_timeout = 5.0});
  insert(map, one_echo(2.0, 0.0), {}, 0.0);
  insert(map, one_echo(0.0, 3.0), {}, 3.8);
  EXPECT_TRUE(is_free(map, {1.0, 0.0, kHeight}));
  insert(map, one_echo(0.0, 3.0), {}, 5.01);
  EXPECT_FALSE(is_known(map, {1.0, 0.0, kHeight}));
  EXPECT_TRUE(is_free(map, {0.0, 1.0, kHeight}));
  EXPECT_TRUE(is_occupied(map, {2.01, 0.0, kHeight})) << "an obstacle stays without a decay";
}

TEST(LocalMap, ABeamDoesNotCoverWhatLiesBehindItsReturn) {
  LocalMap map({});
  insert(map, one_echo(2.0, 0.0), {}, 0.0);
  EXPECT_TRUE(is_free(map, {1.9, 0.0, kHeight}));
  EXPECT_TRUE(is_occupied(map, {2.01, 0.0, kHeight}));
  for (double x = 2.1; x < 4.0; x += 0.05) EXPECT_FALSE(is_known(map, {x, 0.0, kHeight})) << x;
}

TEST(LocalMap, ABeamBeyondTheLeastRangeCoversTheRingWithinIt) {
  LocalMap map({.min_range = 0.8});
  insert(map, one_echo(0.5, 0.0), {}, 0.0);
  EXPECT_FALSE(is_known(map, {0.3, 0.0, kHeight}));
  insert(map, one_echo(2.0, 0.0), {}, 0.1);
  EXPECT_TRUE(is_free(map, {0.3, 0.0, kHeight}));
}

const Footprint kOutline = rectangle(0.89, 0.58, 0.038);

TEST(LocalMap, TheOutlineCoversWhereItStandsAndAllThatItSweeps) {
  LocalMap map({});
  insert(map, one_echo(2.0, 0.0), {}, 0.0);
  map.stand(kOutline, {}, 0.12, 0.0);
  EXPECT_TRUE(is_free(map, {-0.39, 0.27, 0.12}));
  EXPECT_FALSE(is_known(map, {-0.48, 0.0, 0.12}));
  map.stand(kOutline, {-0.9, 0.0, 0.0}, 0.12, 0.5);
  map.stand(kOutline, {-0.9, 0.0, std::numbers::pi / 2.0}, 0.12, 1.0);
  for (double x = -1.29; x < 0.4; x += 0.01) EXPECT_TRUE(is_free(map, {x, 0.0, 0.12})) << x;
  EXPECT_TRUE(is_free(map, {-0.9 + 0.37, 0.37, 0.12})) << "a corner swept over it";
  EXPECT_FALSE(is_known(map, {-2.0, 0.0, 0.12}));
}

TEST(LocalMap, TheOutlineClearsNoObstacle) {
  LocalMap map({.coverage_timeout = 1.0});
  insert(map, one_echo(0.2, 0.0), {-1.0, 0.0, 0.0}, 0.0);
  for (int i = 0; i < 100; ++i) map.stand(kOutline, {-0.8, 0.0, 0.0}, kHeight, 0.1 * i);
  EXPECT_TRUE(is_occupied(map, {-0.79, 0.0, kHeight}));
}

TEST(LocalMap, GroundSweptByTheOutlineExpiresLikeABeamsExceptWhereItStands) {
  LocalMap map({.coverage_timeout = 2.0});
  insert(map, one_echo(0.0, 3.0), {}, 0.0);
  map.stand(kOutline, {}, 0.12, 0.0);
  for (int i = 0; i <= 40; ++i) {
    map.stand(kOutline, {0.9, 0.0, 0.0}, 0.12, 0.1 * i);
    insert(map, one_echo(0.0, 3.0), {}, 0.1 * i);
  }
  EXPECT_FALSE(is_known(map, {-0.3, 0.2, 0.12}));
  EXPECT_TRUE(is_free(map, {0.9, 0.2, 0.12}));
}

TEST(LocalMap, AJumpOfThePoseSweepsNothing) {
  LocalMap map({});
  insert(map, one_echo(2.0, 0.0), {}, 0.0);
  map.stand(kOutline, {}, 0.12, 0.0);
  map.stand(kOutline, {0.0, -4.0, 0.0}, 0.12, 0.1);
  EXPECT_FALSE(is_known(map, {0.0, -2.0, 0.12}));
  EXPECT_TRUE(is_free(map, {0.0, -4.0, 0.12}));
  map.stand(kOutline, {std::nan(""), 0.0, 0.0}, 0.12, 0.2);
  map.stand(kOutline, {1e9, 0.0, 0.0}, 0.12, 0.3);
}

TEST(LocalMap, NothingStaysCoveredAfterAClockReset) {
  LocalMap map({.coverage_timeout = 5.0});
  insert(map, one_echo(2.0, 0.0), {}, 1000.0);
  insert(map, one_echo(0.0, 3.0), {}, 1.0);
  EXPECT_FALSE(is_known(map, {1.0, 0.0, kHeight}));
  EXPECT_TRUE(is_occupied(map, {2.01, 0.0, kHeight}));
}

TEST(LocalMap, IsEmptyOnceAllIsForgotten) {
  LocalMap map({.decay = 1.0, .coverage_timeout = 1.0});
  insert(map, one_echo(2.0, 0.0), {}, 0.0);
  insert(map, {}, {}, 10.0);
  EXPECT_EQ(map.tree().size(), 0U);
  insert(map, one_echo(2.0, 0.0), {}, 10.1);
  EXPECT_TRUE(is_occupied(map, {2.01, 0.0, kHeight}));
}

TEST(LocalMap, RefusesParametersThatContradictEachOther) {
  EXPECT_THROW(LocalMap({.min_range = 5.0, .max_range = 4.0}), std::invalid_argument);
  EXPECT_THROW(LocalMap({.point_cloud_min_z = 2.0, .point_cloud_max_z = 1.0}),
               std::invalid_argument);
  // one range return would not suffice
  EXPECT_THROW(LocalMap({.hit = 0.7}), std::invalid_argument);
  EXPECT_THROW(LocalMap({.resolution = 0.0}), std::invalid_argument);
}

TEST(PoseHistory, CarriesTheLastPoseOnToTheStamp) {
  PoseHistory poses;
  EXPECT_FALSE(poses.at(1.0));
  poses.add({0.0, 0.0, 0.0}, {1.0, 0.0}, 1.0);
  poses.add({0.1, 0.0, 0.0}, {1.0, 0.5}, 1.1);
  EXPECT_FALSE(poses.at(0.9));
  EXPECT_NEAR(poses.at(1.05)->x, 0.05, 1e-12);
  EXPECT_NEAR(poses.at(1.2)->theta, 0.05, 1e-12);
  EXPECT_FALSE(poses.at(1.1 + PoseHistory::kMaxAhead + 0.01));
}

TEST(PoseHistory, StartsOverWhenTimeGoesBack) {
  PoseHistory poses;
  poses.add({5.0, 0.0, 0.0}, {}, 100.0);
  poses.add({1.0, 0.0, 0.0}, {}, 0.5);
  EXPECT_FALSE(poses.at(100.0));
  EXPECT_EQ(poses.at(0.6)->x, 1.0);
}

}  // namespace
}  // namespace tandem
