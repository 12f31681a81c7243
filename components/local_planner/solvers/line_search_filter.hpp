// SPDX-License-Identifier: Apache-2.0
// In: two points on a line, by what they miss and what they cost. Out: whether to take the step.
#pragma once

#include <vector>

namespace tandem {

/// What a line search looks at: ‖residuals of the equalities‖₁ and cost − μ Σ log(distances).
struct Merit {
  double infeasibility, barrier;
};

/// Line-search filter (Wächter and Biegler 2006, section 2.3): a trial point has to be better than
/// every remembered one in one of the two, and better than the present one by a little.
class LineSearchFilter {
 public:
  /// Room for this many steps without an allocation.
  void reserve(std::size_t steps) { corners_.reserve(steps); }

  /// Forgets all points. `infeasibility`: of the first point from now on.
  void reset(double infeasibility);

  /// Whether `trial`, `alpha` of a step away from `now`, is good enough; remembers `now` if the
  /// step was taken for its infeasibility. `slope`: derivative of the barrier along the step.
  [[nodiscard]] bool accepts(const Merit& now, const Merit& trial, double alpha, double slope);

 private:
  std::vector<Merit> corners_;
  double most_ = 0.0, least_ = 0.0;
};

}  // namespace tandem
