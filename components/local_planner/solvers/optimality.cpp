// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/optimality.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr double kLargeMultiplier = 100.0;  // s_max of (6)

// Raises `worst` to `value`. What is not a number stays.
void raise(double& worst, double value) {
  if (!std::isnan(worst) && !(value <= worst)) worst = value;
}

// ∇ cost + Jᵀ λ
std::vector<double> lagrangian_gradient(const Ocp& ocp, const Iterate& point) {
  std::vector<double> gradient(point.z.size());
  cost_gradient(ocp, point.z, gradient);
  const std::vector<Entry> pattern = jacobian_pattern(ocp);
  std::vector<double> jacobian(pattern.size());
  jacobian_values(ocp, point.z, jacobian);
  for (std::size_t i = 0; i < pattern.size(); ++i)
    gradient[static_cast<std::size_t>(pattern[i].column)] +=
        jacobian[i] * point.lambda[static_cast<std::size_t>(pattern[i].row)];
  return gradient;
}

// Adds one-sided bounds to the error.
class Sides {
 public:
  explicit Sides(OptimalityError& error) : error_{error} {}

  // A bound at `distance` with its multiplier; the distance is negative beyond the bound.
  void add(double distance, double multiplier) {
    sum_ += std::abs(multiplier);
    ++count_;
    raise(error_.primal, -distance);
    raise(error_.complementarity, std::abs(distance * multiplier - kFinalBarrier));
  }
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  OptimalityError& error_;
  double sum_ = 0.0;  // of the multipliers' magnitudes
  std::size_t count_ = 0;
};

}  // namespace

OptimalityError optimality_error(const Ocp& ocp, const Iterate& point) {
  const std::vector<double> gradient = lagrangian_gradient(ocp, point);
  std::vector<double> values(point.lambda.size());
  row_values(ocp, point.z, values);
  const Bounds all = bounds(ocp);
  const std::size_t n = gradient.size(), m = values.size();

  OptimalityError out;
  Sides sides(out);
  for (std::size_t i = 0; i < n; ++i) {
    const auto [min, max] = all.variable[i];
    const double lower = point.lower[i], upper = point.upper[i];
    raise(out.dual, std::abs(gradient[i] - lower + upper));
    if (min > -kUnbounded) sides.add(point.z[i] - min, lower);
    if (max < kUnbounded) sides.add(max - point.z[i], upper);
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < m; ++i) {
    sum += std::abs(point.lambda[i]);
    const bool is_equality = i < equalities(ocp) * ocp.stages.size();
    if (is_equality) {
      raise(out.primal, std::abs(values[i]));
    } else {  // values ≥ 0, with a multiplier below 0
      sides.add(values[i], -point.lambda[i]);
      raise(out.dual, point.lambda[i]);
    }
  }
  const double mean = (sum + sides.sum()) / static_cast<double>(m + sides.count());
  out.scale = std::max(kLargeMultiplier, mean) / kLargeMultiplier;
  return out;
}

bool is_optimal(const OptimalityError& error) {
  return error.primal <= kTolerance && error.complementarity <= kTolerance &&
         error.dual <= kTolerance * error.scale;
}

}  // namespace tandem
