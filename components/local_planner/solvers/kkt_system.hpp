// SPDX-License-Identifier: Apache-2.0
// KKT system of the barrier problem: optimality error and Newton step at a primal-dual point.
#pragma once

#include <vector>

#include "tandem/local_planner/solvers/ip_iterate.hpp"
#include "tandem/local_planner/solvers/riccati.hpp"

namespace tandem {

/// Multipliers of the bounds, of rows (4) (y = −λ ≥ 0), of rows (3), (8) (π = −λ) and of rows (2).
template <int n>
struct Multipliers {
  std::vector<double> lower, upper;
  std::vector<double> y;
  std::vector<ChainState<n>> pi;
  std::vector<Eigen::Vector2d> lambda;

  void resize(std::size_t stage_count, std::size_t pair_count);
};

/// Newton step, and the fractions of it that leave at least (1 − τ) of each distance to a bound.
template <int n>
struct Step {
  std::vector<double> z, t, lower, upper, y;
  std::vector<ChainStep<n>> chain;  ///< pi and lambda are the new multipliers, not steps
  double alpha_primal = 1.0, alpha_dual = 1.0;
  double worst_primal = 0.0, worst_dual = 0.0;  ///< largest −Δ / distance
  double slope = 0.0;                           ///< derivative of the barrier objective along it

  void resize(std::size_t stage_count, std::size_t pair_count);
};

/// The primal-dual system of min cost − μ Σ log(distances) subject to (2), (3), (4), (8) of
/// ocp.hpp, condensed: first t, y and the bounds' multipliers are eliminated one by one, then s of
/// each stage, then d, which leaves the chain (1) of riccati.hpp. Owns its memory and does not
/// allocate once it is large enough. n: states that a stage passes on, 3, or 5 with a motor lag.
template <int n>
class KktSystem {
 public:
  void resize(std::size_t stage_count, std::size_t pair_count);

  /// Sets up the system. First clamps the multipliers of bounds and rows (4) to within a factor of
  /// 1e10 of μ / distance.
  void condense(const Ocp& ocp, const Box& box, const IpIterate<n>& point, double mu,
                Multipliers<n>& multipliers);

  /// Largest residual of the optimality conditions at barrier `mu`, scaled as in Ipopt.
  [[nodiscard]] double error(double mu) const;
  /// Largest |distance · multiplier − μ|, unscaled.
  [[nodiscard]] double complementarity(double mu) const;

  /// Solves for the step. Returns false if no regularisation makes the system convex, or if the
  /// step's slope is not finite.
  [[nodiscard]] bool solve(const Ocp& ocp, const IpIterate<n>& point, double mu,
                           const Multipliers<n>& multipliers, Step<n>& step);

  /// Resets the regularisation remembered from earlier solves.
  void reset() { last_delta_ = 0.0; }

 private:
  static constexpr std::size_t kBlock = block_of(n);

  // Recovers the slack step of a stage: Δs = −per (gradient + weights · ΔX − sum speed_margin ·
  // Δu).
  struct SlackTerms {
    double per, gradient, sum;
    Eigen::Vector3d weights;
  };
  // Range of a stage's rows (4).
  struct Rows {
    std::size_t first, end;
  };
  // Step of a stage as it enters its rows (4): ΔX⁺, and Δs minus the step of speed_margin().
  struct PairStep {
    Eigen::Vector3d X;
    double offset;
  };
  // Sums over the pairs of a stage.
  struct PairSums {
    double sigma = 0.0, y = 0.0, gradient = 0.0;
    Eigen::Vector3d sigma_n = Eigen::Vector3d::Zero(), y_n = Eigen::Vector3d::Zero();
    Eigen::Vector3d gradient_n = Eigen::Vector3d::Zero();
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero(), C = Eigen::Matrix3d::Zero();
  };

  void condense_bounds(const Box& box, const IpIterate<n>& point, double mu,
                       Multipliers<n>& multipliers);
  PairSums condense_pairs(Rows rows, const IpIterate<n>& point, double mu,
                          Multipliers<n>& multipliers);
  void condense_stage(const Ocp& ocp, std::size_t k, const StageTerms<n>& stage,
                      const PairSums& pairs, const ChainState<n>& pi);
  static void condense_motion(const Ocp& ocp, const StageTerms<n>& stage, const ChainState<n>& pi,
                              ChainStage<n>& out);
  void look_at_dual(const Ocp& ocp, std::size_t k, const IpIterate<n>& point, const PairSums& pairs,
                    const Multipliers<n>& multipliers);
  [[nodiscard]] bool factorize_convex();
  void expand_pairs(Rows rows, const IpIterate<n>& point, double mu,
                    const Multipliers<n>& multipliers, const PairStep& by, Step<n>& step) const;
  void expand_bounds(double mu, const Multipliers<n>& multipliers, Step<n>& step) const;

  std::vector<ChainStage<n>> stages_;
  std::vector<ChainGain<n>> gains_;
  std::vector<SlackTerms> slacks_;
  std::vector<double> per_lower_, per_upper_;  // 1 / distance
  std::vector<double> sigma_, barrier_;        // Hessian and gradient of the bounds' barrier
  std::vector<double> per_t_;                  // 1 / t
  double last_delta_ = 0.0;

  double dual_ = 0.0, violation_ = 0.0;  // largest residuals
  double least_product_ = 0.0, largest_product_ = 0.0;
  double multipliers_ = 0.0;  // 1-norm of all multipliers
};

}  // namespace tandem
