// SPDX-License-Identifier: Apache-2.0
// Presents an optimal control problem to Ipopt as a TNLP.
#pragma once

#include <IpTNLP.hpp>
#include <vector>

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// The properties of an Ocp that determine its sparsity. Ipopt's setup can be reused while they are
/// unchanged.
struct Structure {
  std::vector<int> pairs;            ///< per stage
  std::vector<signed char> bounded;  ///< per variable: bit 0 below, bit 1 above
  bool fixed = false;                ///< some bounds coincide; Ipopt removes those variables

  friend bool operator==(const Structure&, const Structure&) = default;
};
[[nodiscard]] Structure structure_of(const Ocp& ocp, const Bounds& all);

/// A sequence of problems of the same structure.
class IpoptProblem : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;

  /// Takes the structure of `ocp`; keeps no reference to it.
  explicit IpoptProblem(const Ocp& ocp);

  /// Sets the next problem. `ocp`, `guess` and `limits` must outlive the solve.
  void set(const Ocp& ocp, Bounds all, const Iterate& guess, const SolveLimits& limits);

  /// Result of the last solve; moves its point out. kFailed if the point is not finite.
  [[nodiscard]] Solution solution(Ipopt::ApplicationReturnStatus status);

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_hessian,
                    IndexStyleEnum& style) override;
  bool get_bounds_info(Index n, Number* x_l, Number* x_u, Index m, Number* g_l,
                       Number* g_u) override;
  bool get_starting_point(Index n, bool init_x, Number* x, bool init_z, Number* z_l, Number* z_u,
                          Index m, bool init_lambda, Number* lambda) override;
  bool eval_f(Index n, const Number* x, bool new_x, Number& value) override;
  bool eval_grad_f(Index n, const Number* x, bool new_x, Number* gradient) override;
  bool eval_g(Index n, const Number* x, bool new_x, Index m, Number* g) override;
  bool eval_jac_g(Index n, const Number* x, bool new_x, Index m, Index nnz, Index* row,
                  Index* column, Number* value) override;
  bool eval_h(Index n, const Number* x, bool new_x, Number sigma, Index m, const Number* lambda,
              bool new_lambda, Index nnz, Index* row, Index* column, Number* value) override;
  bool intermediate_callback(Ipopt::AlgorithmMode mode, Index iteration, Number f, Number primal,
                             Number dual, Number mu, Number step, Number regularization,
                             Number alpha_dual, Number alpha_primal, Index trials,
                             const Ipopt::IpoptData* data,
                             Ipopt::IpoptCalculatedQuantities* quantities) override;
  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* x, const Number* z_l,
                         const Number* z_u, Index m, const Number* g, const Number* lambda,
                         Number f, const Ipopt::IpoptData* data,
                         Ipopt::IpoptCalculatedQuantities* quantities) override;

 private:
  using Clock = std::chrono::steady_clock;

  const std::vector<Entry> jacobian_, hessian_;
  const Ocp* ocp_ = nullptr;
  const Iterate* guess_ = nullptr;
  const SolveLimits* limits_ = nullptr;
  Bounds bounds_;
  Iterate end_;
  Clock::time_point first_{}, last_{};
  int iterations_ = 0;
};

}  // namespace tandem
