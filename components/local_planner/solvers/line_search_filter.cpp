// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/line_search_filter.hpp"

#include <algorithm>
#include <cmath>

// Equation numbers: Wächter and Biegler 2006.
namespace tandem {
namespace {

constexpr double kGammaTheta = 1e-5, kGammaPhi = 1e-5, kEta = 1e-8;  // γ_θ, γ_φ, η_φ
constexpr double kRounding = 1e-15;  // relative increase of φ that counts as rounding

}  // namespace

void LineSearchFilter::reset(double infeasibility) {
  corners_.clear();
  most_ = 1e4 * std::max(1.0, infeasibility);
  least_ = 1e-4 * std::max(1.0, infeasibility);
}

bool LineSearchFilter::accepts(const Merit& now, const Merit& trial, double alpha, double slope) {
  if (!std::isfinite(trial.barrier) || !(trial.infeasibility <= most_)) return false;
  const double barrier = trial.barrier - kRounding * std::abs(now.barrier);
  for (const Merit& corner : corners_)
    if (trial.infeasibility > corner.infeasibility && barrier > corner.barrier) return false;
  // Switching condition (19), then Armijo condition (20).
  const bool for_barrier = now.infeasibility <= least_ && slope < 0.0 &&
                           alpha * std::pow(-slope, 2.3) > std::pow(now.infeasibility, 1.1);
  if (for_barrier) return barrier <= now.barrier + kEta * alpha * slope;
  // Sufficient decrease (18), then the new filter entry (22).
  const Merit corner{(1.0 - kGammaTheta) * now.infeasibility,
                     now.barrier - kGammaPhi * now.infeasibility};
  if (trial.infeasibility > corner.infeasibility && barrier > corner.barrier) return false;
  corners_.push_back(corner);
  return true;
}

}  // namespace tandem
