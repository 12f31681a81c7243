// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/navigator.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kSteerPeriod = 0.05;

NavigatorParams params(std::vector<double> route) {
  NavigatorParams p;
  p.route = std::move(route);
  return p;
}

// A robot that executes the hand's commands immediately, in an empty world.
Pose2 drive(Navigator& driver, Pose2 X, double duration) {
  for (double t = 0.0; t < duration && !driver.arrived(); t += kSteerPeriod) {
    const Hand hand = driver.steer(X, X, t);
    X = integrate(X, {0.8 * hand.linear, 0.8 * hand.angular}, kSteerPeriod);
  }
  return X;
}

TEST(Navigator, ReachesTheEndOfItsRoute) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Navigator driver{params({0, 0, 3, 0, 3, 3}), seed};
    drive(driver, {}, 60.0);
    EXPECT_TRUE(driver.arrived()) << "seed " << seed;
  }
}

TEST(Navigator, SameSeedSameDrive) {
  Navigator a{params({0, 0, 5, 2}), 7}, b{params({0, 0, 5, 2}), 7}, c{params({0, 0, 5, 2}), 8};
  const Pose2 X_a = drive(a, {}, 4.0), X_b = drive(b, {}, 4.0), X_c = drive(c, {}, 4.0);
  EXPECT_EQ(X_a, X_b);
  EXPECT_NE(X_a, X_c);
}

TEST(Navigator, ALoopNeverEnds) {
  NavigatorParams p = params({0, 0, 3, 0, 3, 3, 0, 3});
  p.loop = true;
  Navigator driver{p, 1};
  drive(driver, {}, 60.0);
  EXPECT_FALSE(driver.arrived());
}

NavigatorParams patient(std::vector<double> route) {
  NavigatorParams p = params(std::move(route));
  p.stick_noise = p.aim_noise = 0.0;
  p.patience = 60.0;
  return p;
}

// A leader that has passed its waypoint waits for the robot.
TEST(Navigator, WaitsForItsRobotLookingAlongTheRoute) {
  const Pose2 X_MB{0.5, 0.0, 0.0};
  for (const double theta : {-2.5, -0.5, 0.0, 0.5, 2.5}) {
    Navigator driver{patient({0, 0, 5, 0}), 1};
    Pose2 X_ML{1.6 + 0.1 * std::cos(theta), 0.1 * std::sin(theta), theta};
    for (double t = 0.0; t < 5.0; t += kSteerPeriod) {
      const Hand hand = driver.steer(X_MB, X_ML, t);
      EXPECT_EQ(hand.linear, 0.0);
      X_ML.theta += kSteerPeriod * hand.angular;
    }
    EXPECT_NEAR(X_ML.theta, 0.0, 0.05);
  }
}

// Toward the point round the corner, which is the other way about than along the route there.
TEST(Navigator, TurnsALeaderThatLooksTheWrongWayToItsPointOnceItsRobotIsThere) {
  Navigator driver{patient({0, 0, 2, 0, 2, 3}), 1};
  const Pose2 X_MB{1.6, 0.0, 0.0}, X_ML{1.7, 0.0, -1.8};
  EXPECT_GT(driver.steer(X_MB, X_ML, 0.0).angular, 0.5);
}

TEST(Navigator, BacksOutAfterPushingInVain) {
  Navigator driver{params({0, 0, 5, 0}), 3};
  bool backed_out = false;
  for (double t = 0.0; t < 4.0; t += kSteerPeriod)
    backed_out = backed_out || driver.steer({}, {}, t).linear < -0.3;
  EXPECT_TRUE(backed_out);
}

TEST(Navigator, BeginsFartherBackAfterTwoTriesInVain) {
  NavigatorParams p = patient({0, 0, 2, 0, 2, -3});
  p.patience = 5.0;
  Navigator driver{p, 1};
  double t = 0.0;
  const Pose2 X_MJ{2.0, -1.0, -1.57};  // jammed
  const auto push_until = [&](bool backs_out) {
    for (const double end = t + 20.0; t < end; t += kSteerPeriod)
      if ((driver.steer(X_MJ, X_MJ, t).linear < 0.0) == backs_out) return true;
    return false;
  };
  ASSERT_TRUE(push_until(true));
  ASSERT_TRUE(push_until(false));
  ASSERT_TRUE(push_until(true));
  Hand hand{-1.0, 0.0};
  const Pose2 X_MB{1.2, 0.0, -0.87};  // where it came to
  for (const double end = t + 4.5; t < end; t += kSteerPeriod) hand = driver.steer(X_MB, X_MB, t);
  EXPECT_GT(hand.angular, 0.1) << "to a place of the route before that of the trouble";
}

TEST(Navigator, RefusesAnEmptyOrOddRoute) {
  EXPECT_THROW((Navigator{params({}), 1}), std::invalid_argument);
  EXPECT_THROW((Navigator{params({1, 2, 3}), 1}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
