// SPDX-License-Identifier: Apache-2.0
// The step of the condensed system is Newton's: near a solution it squares the error. A wrong term
// in the gradient or Hessian, or in the way back from the condensed system, makes it linear.
#include "tandem/local_planner/solvers/kkt_system.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "local_planner/planning_cases.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

constexpr double kBarrier = 0.01;

// Newton's method on the barrier problem of a random case, from a point well inside the bounds.
template <int n>
class Newton {
 public:
  Newton(const Ocp& ocp, const Iterate& guess) : ocp_{ocp} {
    const std::size_t stages = ocp.stages.size();
    std::size_t pairs = 0;
    for (const auto& stage : ocp.stages) pairs += stage.pairs.size();
    point_.resize(stages, pairs);
    point_.set_problem(ocp);
    multipliers_.resize(stages, pairs);
    system_.resize(stages, pairs);
    step_.resize(stages, pairs);
    is_usable_ = box_.set(ocp);
    point_.z = guess.z;
    for (std::size_t i = 0; i < point_.z.size(); ++i) {
      const double room = std::min(1.0, box_.upper[i] - box_.lower[i]);
      point_.z[i] = std::clamp(point_.z[i], box_.lower[i] + 0.1 * room, box_.upper[i] - 0.1 * room);
    }
    point_.set_slacks(ocp, 0.1);
    for (std::size_t i = 0; i < point_.z.size(); ++i) {
      multipliers_.lower[i] = kBarrier / (point_.z[i] - box_.lower[i]);
      multipliers_.upper[i] = kBarrier / (box_.upper[i] - point_.z[i]);
    }
    for (std::size_t i = 0; i < point_.t.size(); ++i) multipliers_.y[i] = kBarrier / point_.t[i];
    for (auto& pi : multipliers_.pi) pi.setZero();
    for (auto& lambda : multipliers_.lambda) lambda.setZero();
    look();
  }

  [[nodiscard]] bool is_usable() const { return is_usable_; }
  [[nodiscard]] double error() const { return system_.error(kBarrier); }
  // A step of the full length that the bounds leave; returns whether they left all of it.
  bool advance() {
    is_usable_ = is_usable_ && system_.solve(ocp_, point_, kBarrier, multipliers_, step_);
    if (!is_usable_) return false;
    const double primal = step_.alpha_primal, dual = step_.alpha_dual;
    add(point_.z, step_.z, primal);
    add(point_.t, step_.t, primal);
    add(multipliers_.lower, step_.lower, dual);
    add(multipliers_.upper, step_.upper, dual);
    add(multipliers_.y, step_.y, dual);
    for (std::size_t k = 0; k < multipliers_.pi.size(); ++k) {
      multipliers_.pi[k] += primal * (step_.chain[k].pi - multipliers_.pi[k]);
      multipliers_.lambda[k] += primal * (step_.chain[k].lambda - multipliers_.lambda[k]);
    }
    look();
    return primal == 1.0 && dual == 1.0;
  }

 private:
  static void add(std::vector<double>& to, const std::vector<double>& step, double alpha) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += alpha * step[i];
  }
  void look() {
    point_.evaluate(ocp_, box_);
    system_.condense(ocp_, box_, point_, kBarrier, multipliers_);
  }

  const Ocp& ocp_;
  Box box_;
  IpIterate<n> point_;
  Multipliers<n> multipliers_;
  KktSystem<n> system_;
  Step<n> step_;
  bool is_usable_ = false;
};

struct Tally {
  int near = 0, squared = 0;
};

// Counts the full steps from an error between 1e-7 and 1e-4, and those that end below the square,
// with a factor for the curvature.
template <int n>
void tally(const StartingPoint& start, Tally& tally) {
  constexpr int kIterations = 60;
  constexpr double kCurvature = 1e3;
  Newton<n> newton{start.ocp, start.guess};
  for (int i = 0; i < kIterations && newton.is_usable(); ++i) {
    const double before = newton.error();
    const bool is_full = newton.advance();
    if (!is_full || before > 1e-4 || before < 1e-7) continue;
    ++tally.near;
    if (newton.error() < std::max(kCurvature * before * before, 1e-10)) ++tally.squared;
  }
}

TEST(KktSystem, AStepNearTheSolutionSquaresTheError) {
  constexpr unsigned kProblems = samples(400, 60);
  Tally at_once, lagging;
  for (unsigned seed = 0; seed < kProblems; ++seed) {
    const StartingPoint start = first_problem(random_case(seed), false);
    if (start.ocp.lag.any())
      tally<5>(start, lagging);
    else
      tally<3>(start, at_once);
  }
  std::printf("full steps near a solution: %d and %d, of which %d and %d square the error\n",
              at_once.near, lagging.near, at_once.squared, lagging.squared);
  EXPECT_GT(at_once.near, static_cast<int>(kProblems * 3 / 8));
  EXPECT_GT(lagging.near, static_cast<int>(kProblems / 8));
  EXPECT_GT(at_once.squared, 0.97 * at_once.near);
  EXPECT_GT(lagging.squared, 0.97 * lagging.near);
}

}  // namespace
}  // namespace tandem::test
