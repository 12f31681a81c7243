// SPDX-License-Identifier: Apache-2.0
#include "local_planner/ocp.hpp"

#include <array>

#include "local_planner/stage_terms.hpp"

namespace tandem {
namespace {

using Eigen::Vector2d;

std::size_t at(int k, int place) { return static_cast<std::size_t>(k * kBlock + place); }

Twist2 twist_of(std::span<const double> z, int k) { return {z[at(k, kV)], z[at(k, kW)]}; }
Pose2 pose_after(std::span<const double> z, int k) {
  return {z[at(k, kX)], z[at(k, kY)], z[at(k, kTheta)]};
}

CostTerms cost_at(const Ocp& ocp, std::span<const double> z, int k) {
  const StageCost& stage = ocp.stages[static_cast<std::size_t>(k)].cost;
  const Pose2 X = pose_after(z, k);
  return cost_terms(stage, twist_of(z, k), {z[at(k, kDv)], z[at(k, kDw)]}, X.position(),
                    Heading::of(X.theta - stage.X_MR.theta));
}

}  // namespace

int variables(const Ocp& ocp) { return kBlock * ocp.horizon(); }

int rows(const Ocp& ocp) {
  std::size_t count = kEqualities * ocp.stages.size();
  for (const auto& stage : ocp.stages) count += stage.pairs.size();
  return static_cast<int>(count);
}

Pose2 pose_before(const Ocp& ocp, std::span<const double> z, int k) {
  return k == 0 ? ocp.X_MB : pose_after(z, k - 1);
}

double clearance(const Pair& pair, const Pose2& X_MB) {
  return signed_distance(pair.obstacle, transform(X_MB, pair.p_BC)).value - pair.gap;
}

double growth(const Ocp& ocp, const Twist2& twist) {
  return ocp.gap_v * twist.v * twist.v + ocp.gap_w * twist.w * twist.w;
}

Pose2 advance(const Ocp& ocp, const Pose2& X_MB, const Twist2& twist) {
  const Vector2d d = displacement(ocp, Heading::of(X_MB.theta), twist).d;
  return {X_MB.x + d.x(), X_MB.y + d.y(), X_MB.theta + ocp.dt * twist.w};
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
  }
  all.row.assign(static_cast<std::size_t>(rows(ocp)), {0.0, kUnbounded});
  for (std::size_t i = 0; i < kEqualities * ocp.stages.size(); ++i) all.row[i] = {0.0, 0.0};
  return all;
}

double cost(const Ocp& ocp, std::span<const double> z) {
  double sum = 0.0;
  for (int k = 0; k < ocp.horizon(); ++k)
    sum += cost_at(ocp, z, k).value + ocp.slack_weight * z[at(k, kSlack)];
  return sum;
}

void cost_gradient(const Ocp& ocp, std::span<const double> z, std::span<double> gradient) {
  for (int k = 0; k < ocp.horizon(); ++k) {
    const CostTerms c = cost_at(ocp, z, k);
    const std::array<double, kBlock> block{c.u.x(), c.u.y(), c.change.x(), c.change.y(),
                                           c.X.x(), c.X.y(), c.X.z(),      ocp.slack_weight};
    std::copy(block.begin(), block.end(), gradient.begin() + kBlock * k);
  }
}

void row_values(const Ocp& ocp, std::span<const double> z, std::span<double> values) {
  auto pair_row = static_cast<std::size_t>(kEqualities * ocp.horizon());
  for (int k = 0; k < ocp.horizon(); ++k) {
    const Twist2 u = twist_of(z, k), before = k == 0 ? ocp.command : twist_of(z, k - 1);
    const Pose2 X = pose_after(z, k), expected = advance(ocp, pose_before(ocp, z, k), u);
    const auto row = values.subspan(static_cast<std::size_t>(kEqualities * k), kEqualities);
    row[0] = u.v - before.v - z[at(k, kDv)];  // (2)
    row[1] = u.w - before.w - z[at(k, kDw)];
    row[2] = X.x - expected.x;  // (3)
    row[3] = X.y - expected.y;
    row[4] = X.theta - expected.theta;
    for (const Pair& pair : ocp.stages[static_cast<std::size_t>(k)].pairs)
      values[pair_row++] = clearance(pair, X) - growth(ocp, u) + z[at(k, kSlack)];  // (4)
  }
}

std::vector<Entry> jacobian_pattern(const Ocp& ocp) {
  std::vector<Entry> entries;
  for (int k = 0; k < ocp.horizon(); ++k) {
    const int r = kEqualities * k, c = kBlock * k, p = c - kBlock;
    entries.insert(entries.end(), {{r, c + kV}, {r, c + kDv}, {r + 1, c + kW}, {r + 1, c + kDw}});
    for (int i = 0; i < 2; ++i)
      entries.insert(entries.end(),
                     {{r + 2 + i, c + kX + i}, {r + 2 + i, c + kV}, {r + 2 + i, c + kW}});
    entries.insert(entries.end(), {{r + 4, c + kTheta}, {r + 4, c + kW}});
    if (k == 0) continue;
    entries.insert(entries.end(), {{r, p + kV}, {r + 1, p + kW}});
    for (int i = 0; i < 2; ++i)
      entries.insert(entries.end(), {{r + 2 + i, p + kX + i}, {r + 2 + i, p + kTheta}});
    entries.push_back({r + 4, p + kTheta});
  }
  int row = kEqualities * ocp.horizon();
  for (int k = 0; k < ocp.horizon(); ++k)
    for (std::size_t i = 0; i < ocp.stages[static_cast<std::size_t>(k)].pairs.size(); ++i, ++row)
      for (const int place : {kV, kW, kX, kY, kTheta, kSlack})
        entries.push_back({row, kBlock * k + place});
  return entries;
}

void jacobian_values(const Ocp& ocp, std::span<const double> z, std::span<double> values) {
  std::size_t i = 0;
  const auto put = [&](std::initializer_list<double> list) {
    for (const double value : list) values[i++] = value;
  };
  for (int k = 0; k < ocp.horizon(); ++k) {
    const Displacement d =
        displacement(ocp, Heading::of(pose_before(ocp, z, k).theta), twist_of(z, k));
    put({1.0, -1.0, 1.0, -1.0});
    put({1.0, -d.d_v.x(), -d.d_w.x(), 1.0, -d.d_v.y(), -d.d_w.y()});
    put({1.0, -ocp.dt});
    if (k == 0) continue;
    put({-1.0, -1.0, -1.0, -d.d_theta.x(), -1.0, -d.d_theta.y(), -1.0});
  }
  for (int k = 0; k < ocp.horizon(); ++k) {
    const Placed X{pose_after(z, k)};
    const Twist2 u = twist_of(z, k);
    for (const Pair& pair : ocp.stages[static_cast<std::size_t>(k)].pairs) {
      const Eigen::Vector3d g = pair_terms(pair, X).gradient();
      put({-2.0 * ocp.gap_v * u.v, -2.0 * ocp.gap_w * u.w, g.x(), g.y(), g.z(), 1.0});
    }
  }
}

std::vector<Entry> hessian_pattern(const Ocp& ocp) {
  std::vector<Entry> entries;
  for (int k = 0; k < ocp.horizon(); ++k) {
    const int c = kBlock * k, theta_before = c - kBlock + kTheta;
    entries.insert(entries.end(), {{c + kV, c + kV},
                                   {c + kW, c + kV},
                                   {c + kW, c + kW},
                                   {c + kDv, c + kDv},
                                   {c + kDw, c + kDw}});
    for (int i = kX; i <= kTheta; ++i)
      for (int j = kX; j <= i; ++j) entries.push_back({c + i, c + j});
    if (k == 0) continue;
    entries.insert(entries.end(), {{c + kV, theta_before}, {c + kW, theta_before}});
  }
  return entries;
}

void hessian_values(const Ocp& ocp, std::span<const double> z, double sigma,
                    std::span<const double> lambda, std::span<double> values) {
  std::size_t i = 0;
  auto pair_row = static_cast<std::size_t>(kEqualities * ocp.horizon());
  std::size_t theta_theta_before = 0;
  for (int k = 0; k < ocp.horizon(); ++k) {
    const Stage& stage = ocp.stages[static_cast<std::size_t>(k)];
    const CostTerms c = cost_at(ocp, z, k);
    const Placed X{pose_after(z, k)};
    const Displacement d =
        displacement(ocp, Heading::of(pose_before(ocp, z, k).theta), twist_of(z, k));
    const auto row = lambda.subspan(static_cast<std::size_t>(kEqualities * k), kEqualities);
    const Vector2d l{-row[2], -row[3]};  // (3) holds −D

    double crowded = 0.0;  // multipliers of this stage's rows (4)
    Eigen::Matrix3d pose = (sigma * c.X2).asDiagonal();
    for (const Pair& pair : stage.pairs) {
      pose += lambda[pair_row] * pair_terms(pair, X).hessian();
      crowded += lambda[pair_row++];
    }
    const double vv = sigma * c.vv - 2.0 * ocp.gap_v * crowded;
    const double vw = sigma * c.vw + l.dot(d.d_v_w);
    const double ww = sigma * c.ww + l.dot(d.d_w_w) - 2.0 * ocp.gap_w * crowded;

    if (k > 0) values[theta_theta_before] += l.dot(d.d_theta_theta);
    for (const double value : {vv, vw, ww, sigma * c.change2.x(), sigma * c.change2.y()})
      values[i++] = value;
    for (int r = 0; r < 3; ++r)
      for (int s = 0; s <= r; ++s) values[i++] = pose(r, s);
    theta_theta_before = i - 1;
    if (k == 0) continue;
    values[i++] = l.dot(d.d_theta_v);
    values[i++] = l.dot(d.d_theta_w);
  }
}

}  // namespace tandem
