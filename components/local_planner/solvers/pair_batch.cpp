// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/pair_batch.hpp"

#include <cmath>

namespace tandem {
namespace {

template <class Choice, int n>
OutlineDistance<n> select(const Choice& first, const OutlineDistance<n>& a,
                          const OutlineDistance<n>& b) {
  return {first.select(a.value, b.value), first.select(a.n_x, b.n_x), first.select(a.n_y, b.n_y),
          first.select(a.curvature, b.curvature)};
}

}  // namespace

void PairTable::resize(std::size_t pair_count) {
  const std::size_t batches = pair_count / PairBatch::kLanes + 1;  // at least one row more
  for (auto* values : {&value, &n_x, &n_y, &turn, &lean, &curvature})
    values->resize(PairBatch::kLanes * batches);
}

void PairBatch::add(const Pair& pair, std::size_t stage) {
  const auto i = static_cast<Eigen::Index>(count_);
  const Obstacle& obstacle = pair.obstacle;
  a_[i] = obstacle.a;
  b_[i] = obstacle.b;
  if (!is_circle(obstacle)) {
    axis_c_[i] = std::cos(obstacle.angle);
    axis_s_[i] = std::sin(obstacle.angle);
    (is_rectangle(obstacle) ? has_rectangle_ : has_ellipse_) = true;
  }
  is_rectangle_[i] = is_rectangle(obstacle);
  p_x_[i] = obstacle.p_MO.x();
  p_y_[i] = obstacle.p_MO.y();
  arm_x_[i] = pair.p_BC.x();
  arm_y_[i] = pair.p_BC.y();
  gap_[i] = pair.gap;
  stage_[count_++] = stage;
}

OutlineDistance<int{PairBatch::kLanes}> PairBatch::distance_in_axes(const All& q_x,
                                                                    const All& q_y) const {
  const All least = kOffAxes * b_, x = q_x.abs().max(least), y = q_y.abs().max(least);
  auto d = has_ellipse_ ? distance_to_ellipse<int{kLanes}>(a_, b_, x, y)
                        : distance_to_circle<int{kLanes}>(a_, x, y);
  if (has_rectangle_)
    d = select(is_rectangle_, distance_to_rectangle<int{kLanes}>(a_, b_, x, y), d);
  for (Eigen::Index i = 0; i < int{kLanes}; ++i) {
    d.n_x[i] = std::copysign(d.n_x[i], q_x[i]);
    d.n_y[i] = std::copysign(d.n_y[i], q_y[i]);
  }
  return d;
}

OutlineDistance<int{PairBatch::kLanes}> PairBatch::distance(const All& d_x, const All& d_y) const {
  if (!has_ellipse_ && !has_rectangle_) return distance_in_axes(d_x, d_y);
  auto d = distance_in_axes(axis_c_ * d_x + axis_s_ * d_y, axis_c_ * d_y - axis_s_ * d_x);
  const All n_x = axis_c_ * d.n_x - axis_s_ * d.n_y, n_y = axis_s_ * d.n_x + axis_c_ * d.n_y;
  d.n_x = n_x;
  d.n_y = n_y;
  return d;
}

void PairBatch::terms(std::span<const Placed> X, std::size_t first, PairTable& out) const {
  All x, y, c, s;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Placed& at = X[stage_[i]];
    const auto lane = static_cast<Eigen::Index>(i);
    x[lane] = at.p_MB.x();
    y[lane] = at.p_MB.y();
    c[lane] = at.theta.c;
    s[lane] = at.theta.s;
  }
  const All arm_x = c * arm_x_ - s * arm_y_, arm_y = s * arm_x_ + c * arm_y_;
  const auto d = distance(x + arm_x - p_x_, y + arm_y - p_y_);
  const auto row = [first](std::vector<double>& values) { return Eigen::Map<All>{&values[first]}; };
  row(out.value) = d.value - gap_;
  row(out.n_x) = d.n_x;
  row(out.n_y) = d.n_y;
  row(out.turn) = d.n_y * arm_x - d.n_x * arm_y;
  row(out.lean) = d.n_x * arm_x + d.n_y * arm_y;
  row(out.curvature) = d.curvature;
}

}  // namespace tandem
