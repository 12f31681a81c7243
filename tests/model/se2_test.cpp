// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/se2.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace tandem {
namespace {

constexpr double kPi = std::numbers::pi;

Pose2 random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> d(-3.0, 3.0);
  return {d(random), d(random), d(random)};
}

void expect_near(const Pose2& a, const Pose2& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(wrap_angle(a.theta - b.theta), 0.0, tolerance);
}

TEST(WrapAngle, MapsIntoTheHalfOpenCircle) {
  EXPECT_EQ(wrap_angle(0.5), 0.5);
  EXPECT_NEAR(wrap_angle(2.0 * kPi + 0.5), 0.5, 1e-15);
  EXPECT_NEAR(wrap_angle(-7.0 * kPi + 0.5), -kPi + 0.5, 1e-14);
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
}

TEST(Pose2, ComposedWithItsInverseIsTheIdentity) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const Pose2 X = random_pose(random);
    expect_near(compose(X, inverse(X)), {});
    expect_near(compose(inverse(X), X), {});
  }
}

TEST(Pose2, CompositionIsAssociativeAndAgreesWithTransform) {
  std::mt19937 random(2);
  for (int i = 0; i < 1000; ++i) {
    const Pose2 A = random_pose(random), B = random_pose(random), C = random_pose(random);
    expect_near(compose(compose(A, B), C), compose(A, compose(B, C)));
    EXPECT_NEAR(
        (transform(A, transform(B, C.position())) - compose(A, compose(B, C)).position()).norm(),
        0.0, 1e-12);
  }
}

TEST(Integrate, MatchesManySmallEulerSteps) {
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    const Pose2 start = random_pose(random);
    const Twist2 twist{start.y, start.x};
    Pose2 X = start;
    constexpr int kSteps = 200'000;
    const double dt = 1.0 / kSteps;
    for (int k = 0; k < kSteps; ++k)  // midpoint rule
      X = {X.x + twist.v * dt * std::cos(X.theta + 0.5 * twist.w * dt),
           X.y + twist.v * dt * std::sin(X.theta + 0.5 * twist.w * dt), X.theta + twist.w * dt};
    expect_near(integrate(start, twist, 1.0), X, 1e-9);
  }
}

TEST(Integrate, IsContinuousWhereTheTurnRateVanishes) {
  for (const double w : {1e-3, 1e-5, 1e-9, 0.0, -1e-5})
    expect_near(integrate({1.0, 2.0, 0.3}, {0.7, w}, 1.0),
                {1.0 + 0.7 * std::cos(0.3 + w / 2), 2.0 + 0.7 * std::sin(0.3 + w / 2), 0.3 + w},
                1e-7);
}

TEST(Integrate, DoesNotWrapTheHeading) {
  EXPECT_NEAR(integrate({}, {0.0, 1.0}, 10.0).theta, 10.0, 1e-15);
}

TEST(IsFinite, RefusesNaNAndInfinity) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(is_finite(Pose2{1.0, 2.0, 3.0}));
  EXPECT_FALSE(is_finite(Pose2{1.0, nan, 3.0}));
  EXPECT_FALSE(is_finite(Pose2{1.0, 2.0, inf}));
  EXPECT_FALSE(is_finite(Twist2{nan, 0.0}));
  EXPECT_FALSE(is_finite(Twist2{0.0, -inf}));
}

}  // namespace
}  // namespace tandem
