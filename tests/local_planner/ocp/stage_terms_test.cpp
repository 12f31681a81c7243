// SPDX-License-Identifier: Apache-2.0
// Compares the terms of a stage with exact motion and their derivatives with central differences.
#include "tandem/local_planner/ocp/stage_terms.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

using Eigen::Vector2d;

constexpr double kStep = 1e-5;       // of the central differences, whose error is O(step²)
constexpr double kTolerance = 1e-7;  // relative to values of up to about 30
const Ocp kArc{.dt = 0.25, .half = 0.125};
const Ocp kEuler{.dt = 0.25, .half = 0.0};

struct Draw {
  std::mt19937 random{3};
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
};

template <class Value>
Value difference(const Value& after, const Value& before) {
  return (after - before) / (2.0 * kStep);
}

Displacement at(const Ocp& ocp, double theta, const Twist2& u) {
  return displacement(ocp, Heading::of(theta), u);
}

// Turn rates on both sides of the threshold below which a series replaces the quotient.
TEST(Displacement, IsTheChordOfTheArc) {
  Draw draw;
  for (const double w : {0.0, 1e-6, 0.159, 0.161, 1.0, -2.5}) {
    const double theta = draw(-3.0, 3.0);
    const Twist2 u{draw(-1.0, 1.0), w};
    const Vector2d d = at(kArc, theta, u).d;
    const Pose2 X = integrate({0.0, 0.0, theta}, u, kArc.dt);
    EXPECT_NEAR((d - X.position()).norm(), 0.0, 1e-12) << w;
  }
}

TEST(Displacement, OfEulerIsAStepAlongTheHeading) {
  const Vector2d d = at(kEuler, 0.7, {0.8, 1.0}).d;
  EXPECT_NEAR((d - 0.2 * Vector2d(std::cos(0.7), std::sin(0.7))).norm(), 0.0, 1e-15);
}

TEST(Displacement, DerivativesMatchCentralDifferences) {
  Draw draw;
  for (const Ocp& ocp : {kArc, kEuler})
    for (int i = 0; i < 50; ++i) {
      const double theta = draw(-3.0, 3.0);
      const Twist2 u{draw(-1.0, 1.0), i % 5 == 0 ? draw(-0.2, 0.2) : draw(-2.0, 2.0)};
      const Displacement D = at(ocp, theta, u);
      const Displacement left = at(ocp, theta + kStep, u), right = at(ocp, theta - kStep, u);
      const Displacement faster = at(ocp, theta, {u.v + kStep, u.w}),
                         slower = at(ocp, theta, {u.v - kStep, u.w});
      const Displacement more = at(ocp, theta, {u.v, u.w + kStep}),
                         less = at(ocp, theta, {u.v, u.w - kStep});
      const auto expect_near = [](const Vector2d& derivative, const Vector2d& found) {
        EXPECT_NEAR((derivative - found).norm(), 0.0, kTolerance);
      };
      expect_near(D.d_theta, difference(left.d, right.d));
      expect_near(D.d_v, difference(faster.d, slower.d));
      expect_near(D.d_w, difference(more.d, less.d));
      expect_near(D.d_theta_theta, difference(left.d_theta, right.d_theta));
      expect_near(D.d_theta_v, difference(faster.d_theta, slower.d_theta));
      expect_near(D.d_theta_w, difference(more.d_theta, less.d_theta));
      expect_near(D.d_v_w, difference(more.d_v, less.d_v));
      expect_near(D.d_w_w, difference(more.d_w, less.d_w));
    }
}

struct CostPoint {
  Twist2 u, change;
  Vector2d p_MB;
  double error;

  [[nodiscard]] CostTerms terms(const StageCost& cost) const {
    return cost_terms(cost, u, change, p_MB, Heading::of(error));
  }
};

// Terms at the point with one coordinate moved forward and back.
struct Neighbours {
  Neighbours(const StageCost& cost, CostPoint point, double& (*coordinate)(CostPoint&)) {
    coordinate(point) += kStep;
    after = point.terms(cost);
    coordinate(point) -= 2.0 * kStep;
    before = point.terms(cost);
  }
  [[nodiscard]] double slope() const { return difference(after.value, before.value); }

  CostTerms after{}, before{};
};

TEST(CostTerms, DerivativesMatchCentralDifferences) {
  Draw draw;
  for (int i = 0; i < 50; ++i) {
    const StageCost cost{.X_MR = {draw(-2, 2), draw(-2, 2), draw(-3, 3)},
                         .twist = {draw(-1, 1), draw(-1, 1)},
                         .change = {draw(-1, 1), draw(-1, 1)},
                         .q_x = 6,
                         .q_y = 5,
                         .q_xy = draw(-2, 2),
                         .q_theta = 4,
                         .r_v = 0.3,
                         .r_w = 0.15,
                         .c_v = 0.2,
                         .c_w = 0.1,
                         .c_dir = i % 2 == 0 ? 0.65 : 0.0,
                         .direction = draw(-3, 3)};
    const CostPoint point{{draw(0.2, 1), draw(-1, 1)},
                          {draw(-0.1, 0.1), draw(-0.1, 0.1)},
                          {draw(-2, 2), draw(-2, 2)},
                          draw(-3, 3)};
    const CostTerms terms = point.terms(cost);
    const Neighbours v(cost, point, [](CostPoint& p) -> double& { return p.u.v; });
    const Neighbours w(cost, point, [](CostPoint& p) -> double& { return p.u.w; });
    const Neighbours dv(cost, point, [](CostPoint& p) -> double& { return p.change.v; });
    const Neighbours dw(cost, point, [](CostPoint& p) -> double& { return p.change.w; });
    const Neighbours x(cost, point, [](CostPoint& p) -> double& { return p.p_MB.x(); });
    const Neighbours y(cost, point, [](CostPoint& p) -> double& { return p.p_MB.y(); });
    const Neighbours turn(cost, point, [](CostPoint& p) -> double& { return p.error; });
    constexpr double kRough = 1e-5;  // the values differ in their tenth digit
    EXPECT_NEAR(terms.u.x(), v.slope(), kRough);
    EXPECT_NEAR(terms.u.y(), w.slope(), kRough);
    EXPECT_NEAR(terms.change.x(), dv.slope(), kRough);
    EXPECT_NEAR(terms.change.y(), dw.slope(), kRough);
    EXPECT_NEAR(terms.X.x(), x.slope(), kRough);
    EXPECT_NEAR(terms.X.y(), y.slope(), kRough);
    EXPECT_NEAR(terms.X.z(), turn.slope(), kRough);
    EXPECT_NEAR(terms.vv, difference(v.after.u.x(), v.before.u.x()), kRough);
    EXPECT_NEAR(terms.vw, difference(w.after.u.x(), w.before.u.x()), kRough);
    EXPECT_NEAR(terms.ww, difference(w.after.u.y(), w.before.u.y()), kRough);
    EXPECT_NEAR(terms.change2.x(), difference(dv.after.change.x(), dv.before.change.x()), kRough);
    EXPECT_NEAR(terms.change2.y(), difference(dw.after.change.y(), dw.before.change.y()), kRough);
    EXPECT_NEAR(terms.X2.x(), difference(x.after.X.x(), x.before.X.x()), kRough);
    EXPECT_NEAR(terms.X2.y(), difference(y.after.X.y(), y.before.X.y()), kRough);
    EXPECT_NEAR(terms.xy, difference(y.after.X.x(), y.before.X.x()), kRough);
    EXPECT_NEAR(terms.X2.z(), difference(turn.after.X.z(), turn.before.X.z()), kRough);
  }
}

TEST(CostTerms, TheDirectionTermVanishesWhereTheTwistPointsThere) {
  const StageCost cost{
      .X_MR = {}, .twist = {}, .change = {}, .c_dir = 1.0, .direction = std::atan2(0.3, 0.8)};
  const CostTerms along = cost_terms(cost, {0.8, 0.3}, {}, {0.0, 0.0}, Heading::of(0.0));
  const CostTerms against = cost_terms(cost, {-0.8, -0.3}, {}, {0.0, 0.0}, Heading::of(0.0));
  EXPECT_NEAR(along.value, 0.0, 0.01);
  EXPECT_NEAR(against.value, 4.0, 0.01);
}

TEST(PairTerms, DerivativesMatchCentralDifferences) {
  Draw draw;
  for (int i = 0; i < 50; ++i) {
    const Obstacle ellipse{
        .p_MO = {draw(-2, 2), draw(-2, 2)}, .a = 0.8, .b = 0.3, .angle = draw(-2, 2)};
    const Pair pair{{draw(-0.4, 0.4), draw(-0.2, 0.2)}, 0.35, ellipse, 0};
    const double around = draw(-3, 3);  // outside of the ellipse
    const Vector2d p = ellipse.p_MO + 2.0 * Vector2d(std::cos(around), std::sin(around));
    const Pose2 X{p.x(), p.y(), draw(-3, 3)};
    const PairTerms terms = pair_terms(pair, Placed{X});
    for (int k = 0; k < 3; ++k) {
      const auto moved = [&](double step) {
        const Pose2 to{X.x + (k == 0) * step, X.y + (k == 1) * step, X.theta + (k == 2) * step};
        return pair_terms(pair, Placed{to});
      };
      const PairTerms after = moved(kStep), before = moved(-kStep);
      EXPECT_NEAR(terms.gradient()[k], difference(after.value, before.value), 1e-6);
      const Eigen::Vector3d row = difference(after.gradient(), before.gradient());
      EXPECT_NEAR((terms.hessian().col(k) - row).norm(), 0.0, 1e-5) << k;
    }
  }
}

}  // namespace
}  // namespace tandem
