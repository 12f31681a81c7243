// SPDX-License-Identifier: Apache-2.0
#include "driver/navigator.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kPeriod = 0.05;

NavigatorParams params(std::vector<double> route) {
  NavigatorParams p;
  p.route = std::move(route);
  return p;
}

// A robot that does at once what the hand says, in an empty world.
Pose2 drive(Navigator& driver, Pose2 X, double duration) {
  for (double t = 0.0; t < duration && !driver.arrived(); t += kPeriod) {
    const Hand hand = driver.steer(X, X, t);
    X = integrate(X, {0.8 * hand.linear, 0.8 * hand.angular}, kPeriod);
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

// A leader that has passed its point waits for the robot; one that looks the wrong way when that
// has come is turned round.
TEST(Navigator, WaitsForTheRobotNoLongerThanItTakes) {
  const Pose2 X_ML{1.0, 0.0, 3.1};  // the route goes on behind it
  const auto pushes_most = [&](const Pose2& X_MB) {
    NavigatorParams p = params({0, 0, 5, 0});
    p.stick_noise = 0.0;
    p.patience = 60.0;
    Navigator driver{p, 1};
    double most = 0.0;
    for (double t = 0.0; t < 2.0; t += kPeriod)
      most = std::max(most, std::abs(driver.steer(X_MB, X_ML, t).angular));
    return most;
  };
  EXPECT_EQ(pushes_most({0.5, 0.0, 0.0}), 0.0) << "the robot is on its way";
  EXPECT_GT(pushes_most({0.9, 0.0, 0.0}), 0.5) << "the robot is there";
}

TEST(Navigator, BacksOutAfterPushingInVain) {
  Navigator driver{params({0, 0, 5, 0}), 3};
  bool backed_out = false;
  for (double t = 0.0; t < 4.0; t += kPeriod)
    backed_out = backed_out || driver.steer({}, {}, t).linear < -0.3;
  EXPECT_TRUE(backed_out);
}

TEST(Navigator, RefusesAnEmptyOrOddRoute) {
  EXPECT_THROW((Navigator{params({}), 1}), std::invalid_argument);
  EXPECT_THROW((Navigator{params({1, 2, 3}), 1}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
