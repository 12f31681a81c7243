// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/ipopt_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

using Ipopt::Index;
using Ipopt::Number;

std::span<const double> values(const Number* p, Index n) {
  return {p, static_cast<std::size_t>(n)};
}
std::span<double> values(Number* p, Index n) { return {p, static_cast<std::size_t>(n)}; }

bool all_finite(std::span<const double> list) {
  return std::all_of(list.begin(), list.end(), [](double value) { return std::isfinite(value); });
}

void write_pattern(const std::vector<Entry>& entries, Index* rows, Index* columns) {
  for (const Entry& entry : entries) {
    *rows++ = entry.row;
    *columns++ = entry.column;
  }
}

}  // namespace

Structure structure_of(const Ocp& ocp, const Bounds& all) {
  Structure structure;
  structure.pairs.reserve(ocp.stages.size());
  structure.bounded.reserve(all.variable.size());
  for (const Stage& stage : ocp.stages)
    structure.pairs.push_back(static_cast<int>(stage.pairs.size()));
  for (const Interval& range : all.variable) {
    structure.bounded.push_back(static_cast<signed char>((range.min > -kUnbounded ? 1 : 0) |
                                                         (range.max < kUnbounded ? 2 : 0)));
    structure.fixed = structure.fixed || range.min == range.max;
  }
  return structure;
}

IpoptProblem::IpoptProblem(const Ocp& ocp)
    : jacobian_{jacobian_pattern(ocp)}, hessian_{hessian_pattern(ocp)} {}

void IpoptProblem::set(const Ocp& ocp, Bounds all, const Iterate& guess,
                       const SolveLimits& limits) {
  ocp_ = &ocp;
  bounds_ = std::move(all);
  guess_ = &guess;
  limits_ = &limits;
  end_ = {};
  iterations_ = 0;
}

Solution IpoptProblem::solution(Ipopt::ApplicationReturnStatus status) {
  Solution solution{.point = std::move(end_), .iterations = iterations_};
  if (iterations_ > 0)
    solution.iteration_time = std::chrono::duration<double>(last_ - first_).count() / iterations_;
  if (status == Ipopt::Solve_Succeeded)
    solution.status = SolveStatus::kConverged;
  else if (status == Ipopt::Solved_To_Acceptable_Level)
    solution.status = SolveStatus::kAcceptable;
  else if (status == Ipopt::User_Requested_Stop || status == Ipopt::Maximum_Iterations_Exceeded)
    solution.status = SolveStatus::kTimeout;
  const Iterate& point = solution.point;
  const bool usable = point.z.size() == static_cast<std::size_t>(variables(*ocp_)) &&
                      all_finite(point.z) && all_finite(point.lambda);
  if (!usable) solution.status = SolveStatus::kFailed;
  return solution;
}

bool IpoptProblem::get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_hessian,
                                IndexStyleEnum& style) {
  n = variables(*ocp_);
  m = rows(*ocp_);
  nnz_jac = static_cast<Index>(jacobian_.size());
  nnz_hessian = static_cast<Index>(hessian_.size());
  style = C_STYLE;
  return true;
}

bool IpoptProblem::get_bounds_info(Index, Number* x_l, Number* x_u, Index, Number* g_l,
                                   Number* g_u) {
  for (const Interval& range : bounds_.variable) *x_l++ = range.min, *x_u++ = range.max;
  for (const Interval& range : bounds_.row) *g_l++ = range.min, *g_u++ = range.max;
  return true;
}

bool IpoptProblem::get_starting_point(Index, bool, Number* x, bool init_z, Number* z_l, Number* z_u,
                                      Index, bool init_lambda, Number* lambda) {
  std::copy(guess_->z.begin(), guess_->z.end(), x);
  if (init_z) {
    std::copy(guess_->lower.begin(), guess_->lower.end(), z_l);
    std::copy(guess_->upper.begin(), guess_->upper.end(), z_u);
  }
  if (init_lambda) std::copy(guess_->lambda.begin(), guess_->lambda.end(), lambda);
  return true;
}

bool IpoptProblem::eval_f(Index n, const Number* x, bool, Number& value) {
  value = cost(*ocp_, values(x, n));
  return std::isfinite(value);
}

bool IpoptProblem::eval_grad_f(Index n, const Number* x, bool, Number* gradient) {
  cost_gradient(*ocp_, values(x, n), values(gradient, n));
  return true;
}

bool IpoptProblem::eval_g(Index n, const Number* x, bool, Index m, Number* g) {
  row_values(*ocp_, values(x, n), values(g, m));
  return all_finite(values(g, m));
}

bool IpoptProblem::eval_jac_g(Index n, const Number* x, bool, Index, Index nnz, Index* row,
                              Index* column, Number* value) {
  if (value == nullptr)
    write_pattern(jacobian_, row, column);
  else
    jacobian_values(*ocp_, values(x, n), values(value, nnz));
  return true;
}

bool IpoptProblem::eval_h(Index n, const Number* x, bool, Number sigma, Index m,
                          const Number* lambda, bool, Index nnz, Index* row, Index* column,
                          Number* value) {
  if (value == nullptr)
    write_pattern(hessian_, row, column);
  else
    hessian_values(*ocp_, values(x, n), sigma, values(lambda, m), values(value, nnz));
  return true;
}

// Stops unless two more iterations fit before the deadline, because the next one may need several
// factorisations.
bool IpoptProblem::intermediate_callback(Ipopt::AlgorithmMode, Index iteration, Number, Number,
                                         Number, Number, Number, Number, Number, Number, Index,
                                         const Ipopt::IpoptData*,
                                         Ipopt::IpoptCalculatedQuantities*) {
  iterations_ = iteration;
  last_ = Clock::now();
  if (iteration == 0) first_ = last_;
  if (limits_->deadline == Clock::time_point::max()) return true;
  double step = limits_->iteration_time;
  if (iteration > 0)
    step = std::max(step, std::chrono::duration<double>(last_ - first_).count() / iteration);
  return last_ + std::chrono::duration<double>(2.0 * step) < limits_->deadline;
}

void IpoptProblem::finalize_solution(Ipopt::SolverReturn, Index n, const Number* x,
                                     const Number* z_l, const Number* z_u, Index m, const Number*,
                                     const Number* lambda, Number, const Ipopt::IpoptData*,
                                     Ipopt::IpoptCalculatedQuantities*) {
  end_ = {{x, x + n}, {lambda, lambda + m}, {z_l, z_l + n}, {z_u, z_u + n}};
}

}  // namespace tandem
