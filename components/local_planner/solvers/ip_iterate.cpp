// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/ip_iterate.hpp"

#include <algorithm>

namespace tandem {
namespace {

constexpr double kLeastRoom = 2e-6;  // least distance between a variable's bounds

Pose2 pose_of(const double* z) { return {z[kX], z[kY], z[kTheta]}; }
Twist2 command_of(const double* z) { return {z[kV], z[kW]}; }

template <int n>
double product_of_distances(const double* z, const double* lower, const double* upper) {
  double product = 1.0;
  for (std::size_t i = 0; i < block_of(n); ++i) product *= (z[i] - lower[i]) * (upper[i] - z[i]);
  return product;
}

}  // namespace

bool Box::set(const Ocp& ocp) {
  constexpr Interval kFree{-kFar, kFar};
  const Interval place = ocp.workspace > 0.0 ? Interval{-ocp.workspace, ocp.workspace} : kFree;
  const std::size_t length = block(ocp);
  lower.resize(length * ocp.stages.size());
  upper.resize(lower.size());
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Interval all[kMotionW + 1] = {ocp.v[k], ocp.w[k], ocp.change_v[k], ocp.change_w[k],
                                        place,    place,    kFree,           {0.0, kFar},
                                        kFree,    kFree};
    for (std::size_t i = 0; i < length; ++i) {
      if (!(all[i].min <= all[i].max)) return false;
      const double extra = std::max(0.0, 0.5 * (kLeastRoom - (all[i].max - all[i].min)));
      lower[length * k + i] = std::max(-kFar, all[i].min - extra);
      upper[length * k + i] = std::min(kFar, all[i].max + extra);
    }
  }
  return true;
}

template <int n>
void IpIterate<n>::resize(std::size_t stage_count, std::size_t pair_count) {
  z.resize(kBlock * stage_count);
  stages.resize(stage_count);
  targets_.resize(stage_count);
  ends_.resize(stage_count, Placed{{}});
  for (auto* values : {&t, &residuals}) values->resize(pair_count);
  pairs.resize(pair_count);
}

template <int n>
void IpIterate<n>::set_problem(const Ocp& ocp) {
  lanes_.clear();
  for (std::size_t k = 0; k < targets_.size(); ++k) {
    targets_[k] = Heading::of(ocp.stages[k].cost.X_MR.theta);
    for (const Pair& pair : ocp.stages[k].pairs) {
      if (lanes_.empty() || !lanes_.back().has_room()) lanes_.emplace_back();
      lanes_.back().add(pair, k);
    }
  }
}

template <int n>
void IpIterate<n>::set_problem_of(const IpIterate& other) {
  targets_ = other.targets_;
  lanes_ = other.lanes_;
}

template <int n>
void IpIterate<n>::evaluate(const Ocp& ocp, const Box& box) {
  cost = infeasibility = violation = 0.0;
  LogOfProduct distances;
  Pose2 X_before = ocp.X_MB;
  Twist2 motion_before = ocp.motion;
  Heading before = Heading::of(X_before.theta);
  Twist2 u_before = ocp.command;
  for (std::size_t k = 0; k < stages.size(); ++k) ends_[k] = Placed{pose_of(&z[kBlock * k])};
  evaluate_pairs();
  std::size_t row = 0;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const double* at = &z[kBlock * k];
    const Pose2 X = pose_of(at);
    const Placed& after = ends_[k];
    const Twist2 u = command_of(at);
    Twist2 mean = u;
    if constexpr (n == 5) mean = ocp.lag.mean(motion_before, u);
    StageTerms<n>& s = stages[k];
    s.cost = cost_terms(ocp.stages[k].cost, u, {at[kDv], at[kDw]}, after.p_MB,
                        after.theta.from(targets_[k]));
    s.motion = displacement(ocp, before, mean);
    s.change = {u.v - u_before.v - at[kDv], u.w - u_before.w - at[kDw]};
    s.gap.template head<3>() << X_before.x + s.motion.d.x() - X.x,
        X_before.y + s.motion.d.y() - X.y, X_before.theta + ocp.dt * mean.w - X.theta;
    if constexpr (n == 5) {
      const Twist2 motion{at[kMotionV], at[kMotionW]}, end = ocp.lag.end(motion_before, u);
      s.gap.template tail<2>() << end.v - motion.v, end.w - motion.w;
      motion_before = motion;
    }
    s.speed_margin = {2.0 * ocp.gap_v * u.v, 2.0 * ocp.gap_w * u.w};
    cost += s.cost.value + ocp.slack_weight * at[kSlack];
    infeasibility += s.change.template lpNorm<1>() + s.gap.template lpNorm<1>();
    violation = std::max({violation, s.change.template lpNorm<Eigen::Infinity>(),
                          s.gap.template lpNorm<Eigen::Infinity>()});
    distances *= product_of_distances<n>(at, &box.lower[kBlock * k], &box.upper[kBlock * k]);
    row = sum_up_pairs(ocp, k, row, distances);
    X_before = X;
    before = after.theta;
    u_before = u;
  }
  logs = distances.value();
}

template <int n>
void IpIterate<n>::evaluate_pairs() {
  std::size_t row = 0;
  for (const PairBatch& lanes : lanes_) {
    lanes.terms(ends_, row, pairs);
    row += PairBatch::kLanes;
  }
}

template <int n>
std::size_t IpIterate<n>::sum_up_pairs(const Ocp& ocp, std::size_t k, std::size_t first,
                                       LogOfProduct& distances) {
  const double* at = &z[kBlock * k];
  const double offset = at[kSlack] - speed_margin(ocp, command_of(at));
  double sum = 0.0, largest = violation;
  LogOfProduct product = distances;
  const std::size_t end = first + ocp.stages[k].pairs.size();
  for (std::size_t row = first; row < end; ++row) {
    const double residual = pairs.value[row] + offset - t[row];
    residuals[row] = residual;
    sum += std::abs(residual);
    largest = std::max(largest, std::abs(residual));
  }
  std::size_t row = first;
  for (; row + 1 < end; row += 2) product *= t[row] * t[row + 1];
  if (row < end) product *= t[row];
  infeasibility += sum;
  violation = largest;
  distances = product;
  return end;
}

template <int n>
void IpIterate<n>::set_slacks(const Ocp& ocp, double least) {
  for (std::size_t k = 0; k < stages.size(); ++k) ends_[k] = Placed{pose_of(&z[kBlock * k])};
  evaluate_pairs();
  std::size_t row = 0;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const double* at = &z[kBlock * k];
    const double offset = at[kSlack] - speed_margin(ocp, command_of(at));
    for (std::size_t i = 0; i < ocp.stages[k].pairs.size(); ++i, ++row)
      t[row] = std::max(least, pairs.value[row] + offset);
  }
}

template struct IpIterate<3>;
template struct IpIterate<5>;

}  // namespace tandem
