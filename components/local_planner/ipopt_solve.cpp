// SPDX-License-Identifier: Apache-2.0
#include "local_planner/ipopt_solve.hpp"

#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <cmath>
#include <mutex>

namespace tandem {
namespace {

using Clock = std::chrono::steady_clock;
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

// The Ocp as Ipopt wants to see it.
class Problem : public Ipopt::TNLP {
 public:
  Problem(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits)
      : ocp_{ocp},
        guess_{guess},
        limits_{limits},
        jacobian_{jacobian_pattern(ocp)},
        hessian_{hessian_pattern(ocp)} {}

  [[nodiscard]] Solution solution(Ipopt::ApplicationReturnStatus status) const;

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_hessian,
                    IndexStyleEnum& style) override {
    n = variables(ocp_);
    m = rows(ocp_);
    nnz_jac = static_cast<Index>(jacobian_.size());
    nnz_hessian = static_cast<Index>(hessian_.size());
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index, Number* x_l, Number* x_u, Index, Number* g_l, Number* g_u) override {
    const Bounds all = bounds(ocp_);
    for (const Interval& range : all.variable) *x_l++ = range.min, *x_u++ = range.max;
    for (const Interval& range : all.row) *g_l++ = range.min, *g_u++ = range.max;
    return true;
  }

  bool get_starting_point(Index, bool, Number* x, bool init_z, Number* z_l, Number* z_u, Index,
                          bool init_lambda, Number* lambda) override {
    std::copy(guess_.z.begin(), guess_.z.end(), x);
    if (init_z) {
      std::copy(guess_.lower.begin(), guess_.lower.end(), z_l);
      std::copy(guess_.upper.begin(), guess_.upper.end(), z_u);
    }
    if (init_lambda) std::copy(guess_.lambda.begin(), guess_.lambda.end(), lambda);
    return true;
  }

  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = cost(ocp_, values(x, n));
    return std::isfinite(value);
  }
  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    cost_gradient(ocp_, values(x, n), values(gradient, n));
    return true;
  }
  bool eval_g(Index n, const Number* x, bool, Index m, Number* g) override {
    row_values(ocp_, values(x, n), values(g, m));
    return all_finite(values(g, m));
  }
  bool eval_jac_g(Index n, const Number* x, bool, Index, Index nnz, Index* row, Index* column,
                  Number* value) override {
    if (value == nullptr)
      write_pattern(jacobian_, row, column);
    else
      jacobian_values(ocp_, values(x, n), values(value, nnz));
    return true;
  }
  bool eval_h(Index n, const Number* x, bool, Number sigma, Index m, const Number* lambda, bool,
              Index nnz, Index* row, Index* column, Number* value) override {
    if (value == nullptr)
      write_pattern(hessian_, row, column);
    else
      hessian_values(ocp_, values(x, n), sigma, values(lambda, m), values(value, nnz));
    return true;
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Index iteration, Number, Number, Number, Number,
                             Number, Number, Number, Number, Index, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override;

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number* z_l,
                         const Number* z_u, Index m, const Number*, const Number* lambda, Number,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    end_ = {{x, x + n}, {lambda, lambda + m}, {z_l, z_l + n}, {z_u, z_u + n}};
  }

 private:
  const Ocp& ocp_;
  const Iterate& guess_;
  const SolveLimits& limits_;
  const std::vector<Entry> jacobian_, hessian_;
  Iterate end_;
  Clock::time_point first_{}, last_{};
  int iterations_ = 0;
};

// Stops while two more iterations, one of them perhaps with several factorisations, would not fit.
bool Problem::intermediate_callback(Ipopt::AlgorithmMode, Index iteration, Number, Number, Number,
                                    Number, Number, Number, Number, Number, Index,
                                    const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) {
  iterations_ = iteration;
  last_ = Clock::now();
  if (iteration == 0) first_ = last_;
  if (limits_.deadline == Clock::time_point::max()) return true;
  double step = limits_.iteration_time;
  if (iteration > 0)
    step = std::max(step, std::chrono::duration<double>(last_ - first_).count() / iteration);
  return last_ + std::chrono::duration<double>(2.0 * step) < limits_.deadline;
}

Solution Problem::solution(Ipopt::ApplicationReturnStatus status) const {
  Solution solution{.point = end_, .iterations = iterations_};
  if (iterations_ > 0)
    solution.iteration_time = std::chrono::duration<double>(last_ - first_).count() / iterations_;
  if (status == Ipopt::Solve_Succeeded)
    solution.status = SolveStatus::kConverged;
  else if (status == Ipopt::Solved_To_Acceptable_Level)
    solution.status = SolveStatus::kAcceptable;
  else if (status == Ipopt::User_Requested_Stop || status == Ipopt::Maximum_Iterations_Exceeded)
    solution.status = SolveStatus::kTimeout;
  const bool usable = end_.z.size() == static_cast<std::size_t>(variables(ocp_)) &&
                      all_finite(end_.z) && all_finite(end_.lambda);
  if (!usable) solution.status = SolveStatus::kFailed;
  return solution;
}

void set_options(Ipopt::OptionsList& options, bool warm) {
  options.SetStringValue("sb", "yes");
  options.SetIntegerValue("print_level", 0);
  options.SetStringValue("linear_solver", "mumps");
  options.SetStringValue("nlp_scaling_method", "none");
  options.SetNumericValue("tol", 1e-4);
  options.SetNumericValue("constr_viol_tol", 1e-4);
  options.SetNumericValue("acceptable_tol", 1e-3);
  options.SetIntegerValue("acceptable_iter", 5);
  options.SetNumericValue("mu_target", 1e-4);
  options.SetNumericValue("bound_relax_factor", 0.0);
  if (!warm) {
    options.SetStringValue("mu_strategy", "adaptive");
    return;
  }
  options.SetStringValue("warm_start_init_point", "yes");
  options.SetNumericValue("mu_init", 1e-4);
  // So little that an optimum, whose slacks are 1e-4 over a multiplier, stays one.
  for (const char* push :
       {"warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push",
        "warm_start_slack_bound_frac", "warm_start_mult_bound_push"})
    options.SetNumericValue(push, 1e-9);
}

std::timed_mutex& solver_mutex() {
  static std::timed_mutex mutex;
  return mutex;
}

// A thread's applications, for cold and for warm starts. To build one, its some hundred options
// above all, takes longer than a short solve. Of a thread, as Ipopt's object tags are.
class Applications {
 public:
  ~Applications() {
    const std::lock_guard lock{solver_mutex()};  // the last solve's MUMPS goes with them
    cold_ = warm_ = nullptr;
  }
  // Null if Ipopt does not start.
  Ipopt::IpoptApplication* get(bool warm) {
    auto& app = warm ? warm_ : cold_;
    if (IsValid(app)) return GetRawPtr(app);
    app = new Ipopt::IpoptApplication(false);
    set_options(*app->Options(), warm);
    // "": no file of options from wherever the process happens to run.
    if (app->Initialize("") != Ipopt::Solve_Succeeded) app = nullptr;
    return GetRawPtr(app);
  }

 private:
  Ipopt::SmartPtr<Ipopt::IpoptApplication> cold_, warm_;
};

}  // namespace

Solution ipopt_solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits) {
  const bool unlimited = limits.deadline == Clock::time_point::max();
  std::unique_lock lock{solver_mutex(), std::defer_lock};
  if (unlimited)
    lock.lock();
  else if (!lock.try_lock_until(limits.deadline))
    return {.status = SolveStatus::kTimeout, .point = guess};

  thread_local Applications applications;
  Ipopt::IpoptApplication* app = applications.get(!guess.lambda.empty());
  if (app == nullptr) return {};
  app->Options()->SetIntegerValue("max_iter", limits.iterations);
  const Ipopt::SmartPtr<Problem> problem = new Problem(ocp, guess, limits);
  // Not ReOptimizeTNLP: it would keep the first solve's clock and structure.
  return problem->solution(app->OptimizeTNLP(Ipopt::SmartPtr<Ipopt::TNLP>(GetRawPtr(problem))));
}

}  // namespace tandem
