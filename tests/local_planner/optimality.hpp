// SPDX-License-Identifier: Apache-2.0
// Measures how far a primal-dual point is from optimal, using only the problem's sparse form and no
// solver code.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem::test {

/// Largest residuals of the optimality conditions; the first and the last are divided by Ipopt's
/// scale of the multipliers.
struct Optimality {
  double dual = 0.0;             ///< gradient of the Lagrangian
  double primal = 0.0;           ///< rows and bounds
  double complementarity = 0.0;  ///< distance · multiplier
};

inline Optimality optimality(const Ocp& ocp, const Iterate& point) {
  const auto n = static_cast<std::size_t>(variables(ocp)), m = static_cast<std::size_t>(rows(ocp));
  std::vector<double> gradient(n), values(m);
  cost_gradient(ocp, point.z, gradient);
  row_values(ocp, point.z, values);
  const auto pattern = jacobian_pattern(ocp);
  std::vector<double> jacobian(pattern.size());
  jacobian_values(ocp, point.z, jacobian);
  for (std::size_t i = 0; i < pattern.size(); ++i)
    gradient[static_cast<std::size_t>(pattern[i].column)] +=
        jacobian[i] * point.lambda[static_cast<std::size_t>(pattern[i].row)];

  Optimality out;
  double sum = 0.0;
  const Bounds all = bounds(ocp);
  for (std::size_t i = 0; i < n; ++i) {
    const double below = point.z[i] - all.variable[i].min, above = all.variable[i].max - point.z[i];
    const double lower = point.lower[i], upper = point.upper[i];
    out.dual = std::max(out.dual, std::abs(gradient[i] + upper - lower));
    out.primal = std::max({out.primal, -below, -above});
    if (below < 0.1 * kUnbounded)
      out.complementarity = std::max(out.complementarity, below * lower);
    if (above < 0.1 * kUnbounded)
      out.complementarity = std::max(out.complementarity, above * upper);
    sum += std::abs(lower) + std::abs(upper);
  }
  for (std::size_t i = 0; i < m; ++i) {
    const bool is_equality = i < equalities(ocp) * ocp.stages.size();
    out.primal = std::max(out.primal, is_equality ? std::abs(values[i]) : -values[i]);
    if (!is_equality)
      out.complementarity = std::max(out.complementarity, std::abs(values[i] * point.lambda[i]));
    sum += std::abs(point.lambda[i]);
  }
  const double scale = std::max(100.0, sum / static_cast<double>(n + m)) / 100.0;
  out.dual /= scale;
  out.complementarity /= scale;
  return out;
}

}  // namespace tandem::test
