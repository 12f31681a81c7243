// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/deviation.hpp"

#include <gtest/gtest.h>

#include "safety_filter/scenes.hpp"

namespace tandem::test {
namespace {

TEST(Deviation, OppositeSlipMovesTheRobotSidewaysWithTheSquareOfTheDistance) {
  const double slip = 0.02, L = 0.4, s = 1.5;
  Deviation deviation({slip, 0.0, L, 0.0});  // of a point: only the position counts
  for (int i = 0; i < 100; ++i) deviation.advance({0.5, 0.0}, {}, s / 0.5 / 100);
  EXPECT_NEAR(deviation.outline(), slip * s + slip * s * s / L, 1e-9);
}

TEST(Deviation, IsZeroAtTheStartAndNeverFalls) {
  Deviation deviation({0.02, 0.01, 0.4, 0.5});
  EXPECT_EQ(deviation.outline(), 0.0);
  double last = 0.0;
  for (const Twist2 twist : {Twist2{0.5, 0.3}, Twist2{-0.5, 0.3}, Twist2{0.0, -1.0}, Twist2{}}) {
    deviation.advance(twist, {}, 0.1);
    EXPECT_GE(deviation.outline(), last);
    last = deviation.outline();
  }
}

TEST(Deviation, ItsRateBoundsWhatItGrows) {
  const DriftBounds bounds{0.05, 0.02, 0.3, 0.6};
  Deviation deviation(bounds);
  for (int i = 0; i < 50; ++i) {
    const Twist2 twist{0.1 * (i % 7 - 3), 0.2 * (i % 5 - 2)}, tolerance{0.01, 0.02};
    const double before = deviation.outline(), rate = deviation.rate(twist, tolerance, 0.1);
    deviation.advance(twist, tolerance, 0.1);
    EXPECT_LE(deviation.outline() - before, rate * 0.1 + 1e-12);
  }
}

// Corners of an outline that slips, each wheel as it likes, starts with a wrong heading and drives
// with speeds that are a little off.
TEST(Deviation, HoldsEveryRobotWithinTheBounds) {
  Random random(3);
  for (int scene = 0; scene < 500; ++scene) {
    const DriftBounds bounds{uniform(random, 0.0, 0.05), uniform(random, 0.0, 0.03),
                             uniform(random, 0.2, 0.6), uniform(random, 0.3, 0.8)};
    const Twist2 tolerance{uniform(random, 0.0, 0.05), uniform(random, 0.0, 0.05)};
    const double angle = uniform(random, -3.0, 3.0);
    const Eigen::Vector2d corner =
        bounds.radius * Eigen::Vector2d{std::cos(angle), std::sin(angle)};
    const double wrong = uniform(random, -1.0, 1.0) * bounds.heading_error;
    Deviation deviation(bounds);
    Pose2 X, X_true{0.0, 0.0, wrong};
    const Twist2 off{uniform(random, -1.0, 1.0) * tolerance.v,
                     uniform(random, -1.0, 1.0) * tolerance.w};
    const double left = uniform(random, -1.0, 1.0) * bounds.slip;
    const double right = pick(random, 2) ? -left : uniform(random, -1.0, 1.0) * bounds.slip;
    Twist2 twist;
    for (int i = 0; i < 300; ++i) {
      if (i % 50 == 0) twist = {uniform(random, -1.5, 1.5), uniform(random, -2.0, 2.0)};
      const WheelSpeeds rims =
          to_wheels({twist.v + off.v, twist.w + off.w}, bounds.wheel_separation);
      X = integrate(X, twist, 0.01);
      X_true = integrate(
          X_true,
          to_body({(1.0 + left) * rims.left, (1.0 + right) * rims.right}, bounds.wheel_separation),
          0.01);
      deviation.advance(twist, tolerance, 0.01);
      const double d = (transform(X_true, corner) - transform(X, corner)).norm();
      // The margin already includes the rotation of the outline by an initial heading error.
      ASSERT_LE(d, deviation.outline() + bounds.radius * bounds.heading_error + 1e-4) << scene;
    }
  }
}

TEST(Deviation, OfAReachIsNoLessThanThatOfItsMotions) {
  const DriftBounds bounds{0.02, 0.01, 0.4, 0.5};
  Deviation deviation(bounds);
  double path = 0.0, turn = 0.0;
  for (int i = 0; i < 40; ++i) {
    const Twist2 twist{0.3 - 0.02 * i, 0.5 * (i % 3 - 1)};
    deviation.advance(twist, {}, 0.05);
    path += 0.05 * std::abs(twist.v);
    turn += 0.05 * std::abs(twist.w);
    EXPECT_LE(deviation.outline(), largest_deviation(path, turn, bounds) + 1e-12);
  }
}

}  // namespace
}  // namespace tandem::test
