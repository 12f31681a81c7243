// SPDX-License-Identifier: Apache-2.0
// Line-search filter: decides whether the interior point method accepts a trial point.
#pragma once

#include <vector>

namespace tandem {

/// The two measures of a point: θ = ‖residuals of the equalities‖₁ and
/// φ = cost − μ Σ log(distances).
struct Merit {
  double infeasibility, barrier;
};

/// Line-search filter (Wächter and Biegler 2006, section 2.3): a trial point must be better than
/// every filter entry in θ or φ, and sufficiently better than the current point.
class LineSearchFilter {
 public:
  /// Reserves memory for this many steps.
  void reserve(std::size_t steps) { corners_.reserve(steps); }

  /// Clears the filter. `infeasibility`: θ of the new starting point.
  void reset(double infeasibility);

  /// Whether `trial`, the fraction `alpha` of a step away from `now`, is acceptable. Adds an entry
  /// for `now` unless the switching condition holds. `slope`: derivative of φ along the step.
  [[nodiscard]] bool accepts(const Merit& now, const Merit& trial, double alpha, double slope);

 private:
  std::vector<Merit> corners_;       // filter entries (θ, φ)
  double most_ = 0.0, least_ = 0.0;  // θ_max, θ_min
};

}  // namespace tandem
