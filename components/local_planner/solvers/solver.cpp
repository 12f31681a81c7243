// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/solver.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "tandem/local_planner/solvers/ipopt_solve.hpp"
#include "tandem/local_planner/solvers/optimality.hpp"

namespace tandem {
namespace {

constexpr double kSameTwist = 5e-3;  // [m/s, rad/s] tolerance on the first stage's twist
constexpr double kSameCost = 1e-3;   // relative tolerance on the cost
constexpr int kPerIpopt = 30;        // structured iterations in the time of one Ipopt iteration
constexpr int kMaxStructured = 200;

int effort(const Solution& structured) {
  return (structured.iterations + kPerIpopt - 1) / kPerIpopt;
}

bool is_same(const Ocp& ocp, const Solution& a, const Solution& b) {
  const auto &z_a = a.point.z, &z_b = b.point.z;
  const double off = std::hypot(z_a[kV] - z_b[kV], z_a[kW] - z_b[kW]);
  const double cost_a = cost(ocp, z_a), cost_b = cost(ocp, z_b);
  return off <= kSameTwist && std::abs(cost_a - cost_b) <= kSameCost * (1.0 + std::abs(cost_b));
}

// Cost plus a penalty on violated rows, since an infeasible point can have a low cost. The
// penalty's weight is well above that of the slacks.
double price(const Ocp& ocp, const Iterate& point) {
  std::vector<double> values(static_cast<std::size_t>(rows(ocp)));
  row_values(ocp, point.z, values);
  double missed = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool is_equality = i < equalities(ocp) * ocp.stages.size();
    missed += is_equality ? std::abs(values[i]) : std::max(0.0, -values[i]);
  }
  return cost(ocp, point.z) + 10.0 * ocp.slack_weight * missed;
}

bool is_better(const Ocp& ocp, const Solution& a, const Solution& b) {
  if (a.status == SolveStatus::kFailed) return false;
  if (b.status == SolveStatus::kFailed) return true;
  return price(ocp, a.point) <= price(ocp, b.point);
}

}  // namespace

const char* name(SolverKind kind) {
  switch (kind) {
    case SolverKind::kIpopt:
      return "ipopt";
    case SolverKind::kStructured:
      return "structured";
    case SolverKind::kCertified:
      return "certified";
  }
  return "?";
}

const char* name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kUnverified:
      return "unverified";
    case Verdict::kConfirmed:
      return "confirmed";
    case Verdict::kDisagreement:
      return "disagreement";
  }
  return "?";
}

SolverKind solver_named(std::string_view text) {
  for (const SolverKind kind :
       {SolverKind::kIpopt, SolverKind::kStructured, SolverKind::kCertified})
    if (text == name(kind)) return kind;
  throw std::invalid_argument("solver = '" + std::string(text) +
                              "' is not one of {ipopt, structured, certified}");
}

Answer Solver::solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits) {
  switch (kind_) {
    case SolverKind::kIpopt: {
      Answer answer{.solution = ipopt_solve(ocp, guess, limits)};
      answer.effort = answer.solution.iterations;
      return answer;
    }
    case SolverKind::kStructured: {
      Answer answer{.solution = structured(ocp, guess, limits), .by = SolverKind::kStructured};
      answer.effort = effort(answer.solution);
      return answer;
    }
    case SolverKind::kCertified:
      break;
  }
  return certify(ocp, guess, limits);
}

const Solution& Solver::structured(const Ocp& ocp, const Iterate& guess,
                                   const SolveLimits& limits) {
  SolveLimits own = limits;
  own.iterations = std::min(kMaxStructured, kPerIpopt * limits.iterations);
  own.iteration_time = 0.0;
  return structured_.solve(ocp, guess, own);
}

bool Solver::confirms(const Ocp& ocp, const Iterate& point) {
  if (confirmed_ + 1 >= kSpotCheck || !is_optimal(optimality_error(ocp, point))) return false;
  ++confirmed_;
  return true;
}

Answer Solver::certify(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits) {
  SolveLimits all = limits;
  all.known = {};  // a verdict needs both solutions
  const Solution& ours = structured(ocp, guess, all);
  const bool converged = ours.status == SolveStatus::kConverged;
  if (converged && confirms(ocp, ours.point))
    return {.solution = ours,
            .by = SolverKind::kStructured,
            .verdict = Verdict::kConfirmed,
            .effort = effort(ours)};
  confirmed_ = 0;
  Answer answer{.solution = ipopt_solve(ocp, converged ? ours.point : guess, limits)};
  const Solution& theirs = answer.solution;
  const bool interrupted =
      theirs.status == SolveStatus::kTimeout && theirs.iterations < limits.iterations;
  if (!converged)
    answer.verdict = Verdict::kDisagreement;
  else if (!interrupted)
    answer.verdict = theirs.status == SolveStatus::kConverged && is_same(ocp, ours, theirs)
                         ? Verdict::kConfirmed
                         : Verdict::kDisagreement;
  answer.effort = theirs.iterations + effort(ours);
  const int iterations = theirs.iterations + ours.iterations;
  const double iteration_time = theirs.iteration_time;
  if (answer.verdict != Verdict::kDisagreement || is_better(ocp, ours, theirs)) {
    answer.by = SolverKind::kStructured;
    answer.solution = ours;
  }
  answer.solution.iterations = iterations;
  answer.solution.iteration_time = iteration_time;
  return answer;
}

}  // namespace tandem
