// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/pair_batch.hpp"

#include <cmath>

namespace tandem {

void PairBatch::add(const Pair& pair, std::size_t stage) {
  const auto i = static_cast<Eigen::Index>(count_);
  const Obstacle& ellipse = pair.obstacle;
  a_[i] = ellipse.a;
  b_[i] = ellipse.b;
  axis_c_[i] = std::cos(ellipse.angle);
  axis_s_[i] = std::sin(ellipse.angle);
  p_x_[i] = ellipse.p_MO.x();
  p_y_[i] = ellipse.p_MO.y();
  arm_x_[i] = pair.p_BC.x();
  arm_y_[i] = pair.p_BC.y();
  gap_[i] = pair.gap;
  round_ = round_ && ellipse.a == ellipse.b;
  stage_[count_++] = stage;
}

OutlineDistance<int{PairBatch::kLanes}> PairBatch::distance(const All& q_x, const All& q_y) const {
  return round_ ? distance_to_circle<int{kLanes}>(a_, q_x, q_y)
                : distance_to_outline<int{kLanes}>(a_, b_, q_x, q_y);
}

void PairBatch::terms(std::span<const Placed> X, std::span<PairTerms> out) const {
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
  const All d_x = x + arm_x - p_x_, d_y = y + arm_y - p_y_;
  const All q_x = axis_c_ * d_x + axis_s_ * d_y, q_y = axis_c_ * d_y - axis_s_ * d_x;
  const All least = kOffAxes * b_;
  const auto d = distance(q_x.abs().max(least), q_y.abs().max(least));
  const All u = (q_x < 0.0).select(-d.n_x, d.n_x), v = (q_y < 0.0).select(-d.n_y, d.n_y);
  const All n_x = axis_c_ * u - axis_s_ * v, n_y = axis_s_ * u + axis_c_ * v;
  const All value = d.value - gap_, turn = n_y * arm_x - n_x * arm_y;
  const All lean = n_x * arm_x + n_y * arm_y;
  for (std::size_t i = 0; i < count_; ++i) {
    const auto lane = static_cast<Eigen::Index>(i);
    out[i] = {value[lane], n_x[lane], n_y[lane], turn[lane], lean[lane], d.curvature[lane]};
  }
}

}  // namespace tandem
