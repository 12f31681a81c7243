// SPDX-License-Identifier: Apache-2.0
#include "local_planner/chain_point.hpp"

#include <algorithm>

namespace tandem {
namespace {

constexpr double kLeastRoom = 2e-6;  // between two bounds
constexpr std::size_t kFactors = 8;  // per logarithm; their product cannot overflow

Pose2 pose_of(const double* z) { return {z[kX], z[kY], z[kTheta]}; }
Twist2 twist_of(const double* z) { return {z[kV], z[kW]}; }

double log_of_distances(const double* z, const double* lower, const double* upper) {
  double product = 1.0;
  for (int i = 0; i < kBlock; ++i) product *= (z[i] - lower[i]) * (upper[i] - z[i]);
  return std::log(product);
}

double log_of_product(const double* values, std::size_t count) {
  double sum = 0.0;
  for (std::size_t i = 0; i < count; i += kFactors) {
    double product = 1.0;
    for (std::size_t j = i; j < std::min(count, i + kFactors); ++j) product *= values[j];
    sum += std::log(product);
  }
  return sum;
}

StageTerms terms_of(const Ocp& ocp, std::size_t k, const Pose2& before, const Twist2& u_before,
                    const double* z) {
  const Pose2 after = pose_of(z);
  const Twist2 u = twist_of(z);
  const Displacement motion = displacement(ocp, before.theta, u);
  return {.cost = cost_terms(ocp.stages[k].cost, u, {z[kDv], z[kDw]}, after),
          .motion = motion,
          .change = {u.v - u_before.v - z[kDv], u.w - u_before.w - z[kDw]},
          .gap = {before.x + motion.d.x() - after.x, before.y + motion.d.y() - after.y,
                  before.theta + ocp.dt * u.w - after.theta},
          .growth = {2.0 * ocp.gap_v * u.v, 2.0 * ocp.gap_w * u.w}};
}

}  // namespace

void Box::resize(std::size_t stages) {
  lower.resize(kBlock * stages);
  upper.resize(kBlock * stages);
}

bool Box::set(const Ocp& ocp) {
  constexpr Interval kFree{-kFar, kFar};
  const Interval place = ocp.workspace > 0.0 ? Interval{-ocp.workspace, ocp.workspace} : kFree;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Interval all[kBlock] = {ocp.v[k], ocp.w[k], ocp.change_v[k], ocp.change_w[k],
                                  place,    place,    kFree,           {0.0, kFar}};
    for (std::size_t i = 0; i < kBlock; ++i) {
      if (!(all[i].min <= all[i].max)) return false;
      const double extra = std::max(0.0, 0.5 * (kLeastRoom - (all[i].max - all[i].min)));
      lower[kBlock * k + i] = std::max(-kFar, all[i].min - extra);
      upper[kBlock * k + i] = std::min(kFar, all[i].max + extra);
    }
  }
  return true;
}

void ChainPoint::resize(std::size_t stage_count, std::size_t pair_count) {
  z.resize(kBlock * stage_count);
  stages.resize(stage_count);
  for (auto* values : {&t, &residuals}) values->resize(pair_count);
  pairs.resize(pair_count);
}

void ChainPoint::evaluate(const Ocp& ocp, const Box& box) {
  cost = infeasibility = violation = logs = 0.0;
  Pose2 before = ocp.X_MB;
  Twist2 u_before = ocp.command;
  std::size_t row = 0;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const double* at = &z[kBlock * k];
    const StageTerms& s = stages[k] = terms_of(ocp, k, before, u_before, at);
    cost += s.cost.value + ocp.slack_weight * at[kSlack];
    infeasibility += s.change.lpNorm<1>() + s.gap.lpNorm<1>();
    violation =
        std::max({violation, s.change.lpNorm<Eigen::Infinity>(), s.gap.lpNorm<Eigen::Infinity>()});
    logs += log_of_distances(at, &box.lower[kBlock * k], &box.upper[kBlock * k]);
    row = evaluate_pairs(ocp, k, row);
    before = pose_of(at);
    u_before = twist_of(at);
  }
}

std::size_t ChainPoint::evaluate_pairs(const Ocp& ocp, std::size_t k, std::size_t first) {
  const double* at = &z[kBlock * k];
  const Placed X{pose_of(at)};
  const double offset = at[kSlack] - growth(ocp, twist_of(at));
  double sum = 0.0, largest = violation;
  std::size_t row = first;
  for (const Pair& pair : ocp.stages[k].pairs) {
    const PairTerms terms = pair_terms(pair, X);
    const double residual = terms.value + offset - t[row];
    pairs[row] = terms;
    residuals[row] = residual;
    sum += std::abs(residual);
    largest = std::max(largest, std::abs(residual));
    ++row;
  }
  infeasibility += sum;
  violation = largest;
  logs += log_of_product(t.data() + first, row - first);
  return row;
}

void ChainPoint::set_slacks(const Ocp& ocp, double least) {
  std::size_t row = 0;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const double* at = &z[kBlock * k];
    const Placed X{pose_of(at)};
    const double offset = at[kSlack] - growth(ocp, twist_of(at));
    for (const Pair& pair : ocp.stages[k].pairs)
      t[row++] = std::max(least, pair_terms(pair, X).value + offset);
  }
}

}  // namespace tandem
