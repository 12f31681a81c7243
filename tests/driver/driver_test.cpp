// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/driver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tandem {
namespace {

constexpr double kPeriod = 0.05;

DriverParams named(const std::string& name) {
  DriverParams params;
  params.driver = name;
  params.hand.deadzone = 0.0;
  params.navigator.route = {0.0, 0.0, 3.0, 0.0, 3.0, 3.0};
  params.script = "path forward 0.8 via 0 0 2 0 3 1; turn 0; hold 1; path back 0.5 via 3 1 1 1";
  return params;
}

struct Track {
  std::vector<Pose2> X_MB;
  std::vector<Hand> hands;
};

// A robot that executes the hand's commands immediately, in an empty world.
Track drive(Driver& driver, Pose2 X, double duration) {
  Track track;
  for (double t = 0.0; t < duration && !driver.arrived(); t += kPeriod) {
    const Hand hand = driver.steer(X, X, t);
    X = integrate(X, {0.8 * hand.linear, 0.8 * hand.angular}, kPeriod);
    track.X_MB.push_back(X);
    track.hands.push_back(hand);
  }
  return track;
}

double nearest(const Track& track, const Eigen::Vector2d& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose2& X : track.X_MB) best = std::min(best, (X.position() - p).norm());
  return best;
}

// One occupied square of 0.2 m at (2, 1).
std::shared_ptr<const StaticMap> one_block() {
  Grid grid;
  grid.resolution = 0.1;
  grid.width = grid.height = 80;
  grid.origin = {-4.0, -4.0};
  grid.cells.assign(6400, Cell::kFree);
  for (int iy = 49; iy <= 50; ++iy)
    for (int ix = 59; ix <= 60; ++ix)
      grid.cells[static_cast<std::size_t>(iy) * 80 + static_cast<std::size_t>(ix)] =
          Cell::kOccupied;
  return std::make_shared<const StaticMap>(std::move(grid));
}

TEST(Driver, EveryDriverRepeatsItselfForTheSameSeed) {
  for (const auto& name : all_drivers()) {
    if (name == "replay") continue;
    for (const auto& modifier : all_modifiers()) {
      Driver a{named(name + "+" + modifier), 7}, b{named(name + "+" + modifier), 7};
      EXPECT_EQ(drive(a, {}, 10.0).X_MB, drive(b, {}, 10.0).X_MB) << name << " " << modifier;
    }
  }
}

TEST(Driver, AModifierChangesTheHandNotTheIntention) {
  Driver plain{named("navigator"), 3}, trembling{named("navigator+tremor"), 3};
  for (int i = 0; i < 100; ++i) {  // both see the same
    const Pose2 X{0.01 * i, 0.0, 0.0};
    const Hand meant = plain.steer(X, X, i * kPeriod);
    const Hand made = trembling.steer(X, X, i * kPeriod);
    EXPECT_LE(std::abs(made.linear - meant.linear), 0.2 + 1e-9);
    EXPECT_LE(std::abs(made.angular - meant.angular), 0.2 + 1e-9);
  }
}

TEST(Driver, PointerGoesStraightAndNavigatorByTheRoute) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Driver pointer{named("pointer"), seed}, navigator{named("navigator"), seed};
    const Track straight = drive(pointer, {0.0, 0.0, 0.8}, 60.0);
    EXPECT_TRUE(pointer.arrived());
    EXPECT_GT(nearest(straight, {3.0, 0.0}), 1.2) << seed;  // the corner of the route
    EXPECT_LT(nearest(drive(navigator, {}, 60.0), {3.0, 0.0}), 1.0) << seed;
  }
}

TEST(Driver, PointerThatIsHeldTriesBesideTheStraightLineOnBothSides) {
  Driver pointer{named("pointer"), 1};
  int left = 0, right = 0;
  for (double t = 0.0; t < 120.0; t += kPeriod) {
    const Hand hand =
        pointer.steer({3.0, 0.0, std::numbers::pi / 2.0}, {3.0, 0.0, std::numbers::pi / 2.0}, t);
    if (hand.linear > 0.0) (hand.angular > 0.0 ? left : right) += std::abs(hand.angular) > 0.5;
  }
  EXPECT_GT(left, 100);
  EXPECT_GT(right, 100);
}

TEST(Driver, PointerVisitsThePointsOfALoopInTurn) {
  DriverParams params = named("pointer");
  params.navigator.loop = true;
  Driver pointer{params, 1};
  const Track track = drive(pointer, {}, 120.0);
  EXPECT_FALSE(pointer.arrived());
  EXPECT_LT(nearest(track, {3.0, 0.0}), 0.31);
  EXPECT_LT(nearest(track, {3.0, 3.0}), 0.31);
  EXPECT_GT(track.X_MB.size(), 2000u);
}

TEST(Driver, RecklessPushesFullyInAllDirectionsForItsTime) {
  DriverParams params = named("reckless");
  params.reckless_time = 100.0;
  Driver driver{params, 5};
  const Track track = drive(driver, {}, 200.0);
  EXPECT_NEAR(static_cast<double>(track.hands.size()) * kPeriod, 100.0, 0.2);
  int forward = 0, back = 0, left = 0, right = 0;
  for (const Hand& hand : track.hands) {
    EXPECT_TRUE(std::abs(hand.linear) == 1.0 || !hand.holds);
    (hand.linear > 0.0 ? forward : back) += 1;
    (hand.angular > 0.0 ? left : right) += 1;
  }
  for (const int count : {forward, back, left, right}) EXPECT_GT(count, 200);
}

TEST(Driver, AdversaryDrivesAtTheNearestObstacleFromAnywhere) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Driver driver{named("adversary"), seed};
    driver.on_map(one_block());
    const double heading = 0.3 * seed;
    EXPECT_LT(nearest(drive(driver, {0.5, 0.0, heading}, 10.0), {2.0, 1.0}), 0.2) << seed;
  }
}

TEST(Driver, AdversaryTakesARunUpWhenItIsHeld) {
  Driver driver{named("adversary"), 2};
  driver.on_map(one_block());
  const Pose2 held{1.0, 1.0, 0.0};
  int toward = 0, elsewhere = 0;
  for (double t = 0.0; t < 60.0; t += kPeriod) {
    const Hand hand = driver.steer(held, held, t);
    EXPECT_EQ(std::abs(hand.linear), 1.0);
    (hand.linear > 0.0 && std::abs(hand.angular) < 0.2 ? toward : elsewhere) += 1;
  }
  EXPECT_GT(toward, 300);
  EXPECT_GT(elsewhere, 100);
}

TEST(Driver, ReplayHoldsEachSampleUntilTheNextAndThenLetsGo) {
  DriverParams params = named("replay");
  params.replay_t = {100.0, 100.5, 101.0};
  params.replay_linear = {0.1, 0.2, 0.3};
  params.replay_angular = {-0.1, 0.0, 0.5};
  Driver driver{params, 1};
  EXPECT_EQ(driver.steer({}, {}, 7.0).linear, 0.1);
  EXPECT_EQ(driver.steer({}, {}, 7.49).angular, -0.1);
  EXPECT_EQ(driver.steer({}, {}, 7.5).linear, 0.2);
  EXPECT_EQ(driver.steer({}, {}, 8.05).angular, 0.5);
  EXPECT_FALSE(driver.arrived());
  EXPECT_FALSE(driver.steer({}, {}, 8.2).holds);
  EXPECT_TRUE(driver.arrived());
}

TEST(Driver, RefusesInvalidParameters) {
  for (const char* name : {"", "pilot", "navigator+", "navigator+hiccup", "tremor"})
    EXPECT_THROW((Driver{named(name), 1}), std::invalid_argument) << name;
  EXPECT_THROW((Driver{named("replay"), 1}), std::invalid_argument);  // without a recording
  DriverParams lost = named("pointer");
  lost.navigator.route.clear();
  EXPECT_THROW((Driver{lost, 1}), std::invalid_argument);
  DriverParams backwards = named("replay");
  backwards.replay_t = {1.0, 0.0};
  backwards.replay_linear = backwards.replay_angular = {0.0, 0.0};
  EXPECT_THROW((Driver{backwards, 1}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
