// SPDX-License-Identifier: Apache-2.0
// Primal point of the interior point method, with all terms of the Ocp evaluated in one pass.
#pragma once

#include <cmath>
#include <vector>

#include "tandem/local_planner/ocp/stage_terms.hpp"
#include "tandem/local_planner/solvers/line_search_filter.hpp"
#include "tandem/local_planner/solvers/pair_batch.hpp"

namespace tandem {

/// Bounds of all variables. Missing bounds are at ±kFar, where their barrier has no effect. Bounds
/// that coincide or nearly do are widened, because the method needs an interior.
struct Box {
  static constexpr double kFar = 1e10;
  std::vector<double> lower, upper;

  /// Returns false if a bound is NaN or a lower bound exceeds its upper bound.
  [[nodiscard]] bool set(const Ocp& ocp);
};

/// Σ log of many factors with few calls of log.
class LogOfProduct {
 public:
  void operator*=(double factor) {
    product_ *= factor;
    if (product_ > 1e-100 && product_ < 1e100) return;
    sum_ += std::log(product_);
    product_ = 1.0;
  }
  [[nodiscard]] double value() const { return sum_ + std::log(product_); }

 private:
  double product_ = 1.0, sum_ = 0.0;
};

/// Terms of a stage at a point. n: states that it passes on, 3, or 5 with a motor lag.
template <int n>
struct StageTerms {
  CostTerms cost;
  Displacement motion;
  Eigen::Vector2d change;           ///< residuals of rows (2)
  Eigen::Matrix<double, n, 1> gap;  ///< f(X, u) − X⁺: rows (3) and (8), negated
  Eigen::Vector2d speed_margin;     ///< gradient of speed_margin() with respect to u
};

/// Variables z and slacks t > 0 of rows (4), φ − gap − speed_margin + s − t = 0, and the terms that
/// follow from them.
template <int n>
struct IpIterate {
  static constexpr std::size_t kBlock = block_of(n);
  std::vector<double> z, t;
  std::vector<StageTerms<n>> stages;
  PairTable pairs;                ///< of rows (4)
  std::vector<double> residuals;  ///< of rows (4)
  double cost = 0.0;
  double infeasibility = 0.0;  ///< Σ |residuals|
  double violation = 0.0;      ///< max |residuals|
  double logs = 0.0;           ///< Σ log(distance) over all bounds and t

  [[nodiscard]] Merit merit(double mu) const { return {infeasibility, cost - mu * logs}; }
  void resize(std::size_t stage_count, std::size_t pair_count);
  /// Must be called after resize() and whenever the problem has changed; or another point's.
  void set_problem(const Ocp& ocp);
  void set_problem_of(const IpIterate& other);
  /// Computes all other members from z and t.
  void evaluate(const Ocp& ocp, const Box& box);
  /// t = φ − gap − speed_margin + s, but at least `least`.
  void set_slacks(const Ocp& ocp, double least);

 private:
  void evaluate_pairs();
  // Adds the rows (4) of stage k to the sums. `first`: its first row; returns the next stage's.
  std::size_t sum_up_pairs(const Ocp& ocp, std::size_t k, std::size_t first,
                           LogOfProduct& distances);

  std::vector<Heading> targets_;  // target headings of the stages
  std::vector<Placed> ends_;      // poses at the ends of the stages
  std::vector<PairBatch> lanes_;  // rows (4)
};

}  // namespace tandem
