// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/ocp.hpp"

#include <algorithm>
#include <array>

#include "tandem/local_planner/ocp/stage_terms.hpp"

namespace tandem {
namespace {

using Eigen::Vector2d;

CostTerms cost_at(const Ocp& ocp, std::span<const double> z, std::size_t k) {
  const StageCost& stage = ocp.stages[k].cost;
  const Pose2 X = pose_after(ocp, z, k);
  return cost_terms(stage, twist_of(ocp, z, k), {at(ocp, z, k, kDv), at(ocp, z, k, kDw)},
                    X.position(), Heading::of(X.theta - stage.X_MR.theta));
}

Displacement motion_at(const Ocp& ocp, std::span<const double> z, std::size_t k) {
  const Moving before = moving_before(ocp, z, k);
  return displacement(ocp, Heading::of(before.X_MB.theta),
                      ocp.lag.mean(before.twist, twist_of(ocp, z, k)));
}

}  // namespace

int variables(const Ocp& ocp) { return static_cast<int>(block(ocp)) * ocp.horizon(); }

int rows(const Ocp& ocp) {
  std::size_t count = equalities(ocp) * ocp.stages.size();
  for (const auto& stage : ocp.stages) count += stage.pairs.size();
  return static_cast<int>(count);
}

Moving moving_before(const Ocp& ocp, std::span<const double> z, std::size_t k) {
  const Pose2 X_MB = k == 0 ? ocp.X_MB : pose_after(ocp, z, k - 1);
  if (k == 0 || !ocp.lag.any()) return {X_MB, ocp.motion};
  return {X_MB, {at(ocp, z, k - 1, kMotionV), at(ocp, z, k - 1, kMotionW)}};
}

double clearance(const Pair& pair, const Pose2& X_MB) {
  return signed_distance(pair.obstacle, transform(X_MB, pair.p_BC)).value - pair.gap;
}

double speed_margin(const Ocp& ocp, const Twist2& twist) {
  return ocp.gap_v * twist.v * twist.v + ocp.gap_w * twist.w * twist.w;
}

Pose2 advance(const Ocp& ocp, const Pose2& X_MB, const Twist2& mean) {
  const Vector2d d = displacement(ocp, Heading::of(X_MB.theta), mean).d;
  return {X_MB.x + d.x(), X_MB.y + d.y(), X_MB.theta + ocp.dt * mean.w};
}

Moving advance(const Ocp& ocp, const Moving& from, const Twist2& u) {
  return {advance(ocp, from.X_MB, ocp.lag.mean(from.twist, u)), ocp.lag.end(from.twist, u)};
}

Bounds bounds(const Ocp& ocp) {
  constexpr Interval kFree{-kUnbounded, kUnbounded};
  const Interval place = ocp.workspace > 0.0 ? Interval{-ocp.workspace, ocp.workspace} : kFree;
  Bounds all;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    all.variable.insert(all.variable.end(), {ocp.v[k],
                                             ocp.w[k],
                                             ocp.change_v[k],
                                             ocp.change_w[k],
                                             place,
                                             place,
                                             kFree,
                                             {0.0, kUnbounded}});
    if (ocp.lag.any()) all.variable.insert(all.variable.end(), 2, kFree);
  }
  all.row.assign(static_cast<std::size_t>(rows(ocp)), {0.0, kUnbounded});
  std::fill_n(all.row.begin(), equalities(ocp) * ocp.stages.size(), Interval{0.0, 0.0});
  return all;
}

double cost(const Ocp& ocp, std::span<const double> z) {
  double sum = 0.0;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k)
    sum += cost_at(ocp, z, k).value + ocp.slack_weight * at(ocp, z, k, kSlack);
  return sum;
}

void cost_gradient(const Ocp& ocp, std::span<const double> z, std::span<double> gradient) {
  auto out = gradient.begin();
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const CostTerms c = cost_at(ocp, z, k);
    const std::array<double, kMotionW + 1> all{c.u.x(), c.u.y(), c.change.x(), c.change.y(),
                                               c.X.x(), c.X.y(), c.X.z(),      ocp.slack_weight};
    out = std::copy_n(all.begin(), block(ocp), out);
  }
}

void row_values(const Ocp& ocp, std::span<const double> z, std::span<double> values) {
  const std::size_t equality_rows = equalities(ocp);
  auto pair_row = equality_rows * ocp.stages.size();
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Twist2 u = twist_of(ocp, z, k), before = k == 0 ? ocp.command : twist_of(ocp, z, k - 1);
    const Pose2 X = pose_after(ocp, z, k);
    const Moving expected = advance(ocp, moving_before(ocp, z, k), u);
    const auto row = values.subspan(equality_rows * k, equality_rows);
    row[0] = u.v - before.v - at(ocp, z, k, kDv);  // (2)
    row[1] = u.w - before.w - at(ocp, z, k, kDw);
    row[2] = X.x - expected.X_MB.x;  // (3)
    row[3] = X.y - expected.X_MB.y;
    row[4] = X.theta - expected.X_MB.theta;
    if (ocp.lag.any()) {  // (8)
      row[5] = at(ocp, z, k, kMotionV) - expected.twist.v;
      row[6] = at(ocp, z, k, kMotionW) - expected.twist.w;
    }
    for (const Pair& pair : ocp.stages[k].pairs)
      values[pair_row++] =
          clearance(pair, X) - speed_margin(ocp, u) + at(ocp, z, k, kSlack);  // (4)
  }
}

std::vector<Entry> jacobian_pattern(const Ocp& ocp) {
  const bool lags = ocp.lag.any();
  const int each = static_cast<int>(equalities(ocp)), length = static_cast<int>(block(ocp));
  std::vector<Entry> entries;
  const auto add = [&](std::initializer_list<Entry> list) { entries.insert(entries.end(), list); };
  for (int k = 0; k < ocp.horizon(); ++k) {
    const int r = each * k, c = length * k, p = c - length;
    add({{r, c + kV}, {r, c + kDv}, {r + 1, c + kW}, {r + 1, c + kDw}});
    for (int i = 0; i < 2; ++i)
      add({{r + 2 + i, c + kX + i}, {r + 2 + i, c + kV}, {r + 2 + i, c + kW}});
    add({{r + 4, c + kTheta}, {r + 4, c + kW}});
    if (lags)
      for (int i = 0; i < 2; ++i) add({{r + 5 + i, c + kMotionV + i}, {r + 5 + i, c + kV + i}});
    if (k == 0) continue;
    add({{r, p + kV}, {r + 1, p + kW}});
    for (int i = 0; i < 2; ++i) add({{r + 2 + i, p + kX + i}, {r + 2 + i, p + kTheta}});
    add({{r + 4, p + kTheta}});
    if (!lags) continue;
    for (int i = 0; i < 2; ++i)
      add({{r + 2 + i, p + kMotionV}, {r + 2 + i, p + kMotionW}, {r + 5 + i, p + kMotionV + i}});
    add({{r + 4, p + kMotionW}});
  }
  int row = each * ocp.horizon();
  for (int k = 0; k < ocp.horizon(); ++k)
    for (std::size_t i = 0; i < ocp.stages[static_cast<std::size_t>(k)].pairs.size(); ++i, ++row)
      for (const int place : {kV, kW, kX, kY, kTheta, kSlack})
        entries.push_back({row, length * k + place});
  return entries;
}

void jacobian_values(const Ocp& ocp, std::span<const double> z, std::span<double> values) {
  std::size_t i = 0;
  const auto put = [&](std::initializer_list<double> list) {
    for (const double value : list) values[i++] = value;
  };
  const LagStep& lag = ocp.lag;
  const double of_v = 1.0 - lag.share_v, of_w = 1.0 - lag.share_w;  // ∂m/∂u
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Displacement d = motion_at(ocp, z, k);
    put({1.0, -1.0, 1.0, -1.0});
    for (const int j : {0, 1}) put({1.0, -of_v * d.d_v[j], -of_w * d.d_w[j]});
    put({1.0, -of_w * ocp.dt});
    if (lag.any()) put({1.0, lag.decay_v - 1.0, 1.0, lag.decay_w - 1.0});
    if (k == 0) continue;
    put({-1.0, -1.0, -1.0, -d.d_theta.x(), -1.0, -d.d_theta.y(), -1.0});
    if (!lag.any()) continue;
    put({-lag.share_v * d.d_v.x(), -lag.share_w * d.d_w.x(), -lag.decay_v});
    put({-lag.share_v * d.d_v.y(), -lag.share_w * d.d_w.y(), -lag.decay_w});
    put({-lag.share_w * ocp.dt});
  }
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Placed X{pose_after(ocp, z, k)};
    const Twist2 u = twist_of(ocp, z, k);
    for (const Pair& pair : ocp.stages[k].pairs) {
      const Eigen::Vector3d g = pair_terms(pair, X).gradient();
      put({-2.0 * ocp.gap_v * u.v, -2.0 * ocp.gap_w * u.w, g.x(), g.y(), g.z(), 1.0});
    }
  }
}

std::vector<Entry> hessian_pattern(const Ocp& ocp) {
  const int length = static_cast<int>(block(ocp));
  std::vector<Entry> entries;
  const auto add = [&](std::initializer_list<Entry> list) { entries.insert(entries.end(), list); };
  for (int k = 0; k < ocp.horizon(); ++k) {
    const int c = length * k, p = c - length;
    add({{c + kV, c + kV},
         {c + kW, c + kV},
         {c + kW, c + kW},
         {c + kDv, c + kDv},
         {c + kDw, c + kDw}});
    for (int i = kX; i <= kTheta; ++i)
      for (int j = kX; j <= i; ++j) add({{c + i, c + j}});
    if (k == 0) continue;
    add({{c + kV, p + kTheta}, {c + kW, p + kTheta}});
    if (!ocp.lag.any()) continue;
    add({{p + kMotionV, p + kTheta},
         {p + kMotionW, p + kTheta},
         {p + kMotionW, p + kMotionV},
         {p + kMotionW, p + kMotionW},
         {c + kV, p + kMotionW},
         {c + kW, p + kMotionV},
         {c + kW, p + kMotionW}});
  }
  return entries;
}

void hessian_values(const Ocp& ocp, std::span<const double> z, double sigma,
                    std::span<const double> lambda, std::span<double> values) {
  std::size_t i = 0;
  const auto put = [&](std::initializer_list<double> list) {
    for (const double value : list) values[i++] = value;
  };
  const LagStep& lag = ocp.lag;
  const double of_v = 1.0 - lag.share_v, of_w = 1.0 - lag.share_w;  // ∂m/∂u
  const std::size_t equality_rows = equalities(ocp);
  auto pair_row = equality_rows * ocp.stages.size();
  std::size_t theta_theta_before = 0;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Stage& stage = ocp.stages[k];
    const CostTerms c = cost_at(ocp, z, k);
    const Placed X{pose_after(ocp, z, k)};
    const Displacement d = motion_at(ocp, z, k);
    const auto row = lambda.subspan(equality_rows * k, equality_rows);
    const Vector2d l{-row[2], -row[3]};  // (3) contains −D

    double crowded = 0.0;  // sum of the multipliers of this stage's rows (4)
    Eigen::Matrix3d pose = (sigma * c.X2).asDiagonal();
    pose(1, 0) = sigma * c.xy;  // only the lower triangle is read
    for (const Pair& pair : stage.pairs) {
      pose += lambda[pair_row] * pair_terms(pair, X).hessian();
      crowded += lambda[pair_row++];
    }
    const double l_vw = l.dot(d.d_v_w), l_ww = l.dot(d.d_w_w);
    const double l_tv = l.dot(d.d_theta_v), l_tw = l.dot(d.d_theta_w);
    const double vv = sigma * c.vv - 2.0 * ocp.gap_v * crowded;
    const double vw = sigma * c.vw + of_v * of_w * l_vw;
    const double ww = sigma * c.ww + of_w * of_w * l_ww - 2.0 * ocp.gap_w * crowded;

    if (k > 0) values[theta_theta_before] += l.dot(d.d_theta_theta);
    put({vv, vw, ww, sigma * c.change2.x(), sigma * c.change2.y()});
    for (int r = 0; r < 3; ++r)
      for (int s = 0; s <= r; ++s) values[i++] = pose(r, s);
    theta_theta_before = i - 1;
    if (k == 0) continue;
    put({of_v * l_tv, of_w * l_tw});
    if (!lag.any()) continue;
    put({lag.share_v * l_tv, lag.share_w * l_tw, lag.share_v * lag.share_w * l_vw,
         lag.share_w * lag.share_w * l_ww, of_v * lag.share_w * l_vw, of_w * lag.share_v * l_vw,
         of_w * lag.share_w * l_ww});
  }
}

}  // namespace tandem
