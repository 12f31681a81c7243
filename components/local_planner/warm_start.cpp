// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/warm_start.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tandem {
namespace {

constexpr double kBarrier = 1e-4;  // barrier parameter at the solvers' end

// Stage k of the new problem in stages of the old one: (1 − r) · first + r · second.
struct Between {
  std::size_t first, second;
  double r;

  [[nodiscard]] double of(double a, double b) const { return (1.0 - r) * a + r * b; }
};

Between between(const Solved& last, double elapsed, std::size_t k) {
  const std::size_t end = last.ocp.stages.size() - 1;
  const double f = static_cast<double>(k) + elapsed / last.ocp.dt;
  if (f >= static_cast<double>(end)) return {end, end, 0.0};
  const double floor = std::floor(f);
  return {static_cast<std::size_t>(floor), static_cast<std::size_t>(floor) + 1, f - floor};
}

// `width` entries per stage, interpolated between stages.
std::vector<double> interpolate(const std::vector<double>& values, const Solved& last,
                                double elapsed, std::size_t stages, std::size_t width) {
  std::vector<double> out;
  for (std::size_t k = 0; k < stages; ++k) {
    const Between b = between(last, elapsed, k);
    for (std::size_t i = 0; i < width; ++i)
      out.push_back(b.of(values[width * b.first + i], values[width * b.second + i]));
  }
  return out;
}

// Index of each stage's first row (4).
std::vector<std::size_t> first_pair_rows(const Ocp& ocp) {
  std::vector<std::size_t> rows;
  std::size_t row = equalities(ocp) * ocp.stages.size();
  for (const Stage& stage : ocp.stages) {
    rows.push_back(row);
    row += stage.pairs.size();
  }
  return rows;
}

// Identifiers may be unset or reused, so the positions must agree as well.
bool is_same(const Obstacle& a, const Obstacle& b) {
  return a.id == b.id && (a.p_MO - b.p_MO).norm() < 0.2;
}

// Multiplier of the old stage's row for the same disc and obstacle, or `otherwise`.
double multiplier(const Solved& last, const std::vector<std::size_t>& first, std::size_t k,
                  const Pair& pair, double otherwise) {
  const auto& pairs = last.ocp.stages[k].pairs;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (pairs[i].disc == pair.disc && is_same(pairs[i].obstacle, pair.obstacle))
      return last.point.lambda[first[k] + i];
  return otherwise;
}

void set_slacks(const Ocp& ocp, std::vector<double>& z) {
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    double& slack = z[block(ocp) * k + kSlack];
    const Pose2 X = pose_after(ocp, z, k);
    for (const Pair& pair : ocp.stages[k].pairs) slack = std::max(slack, -clearance(pair, X));
  }
}

void set_changes(const Ocp& ocp, std::vector<double>& z) {
  Twist2 before = ocp.command;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Twist2 u = twist_of(ocp, z, k);
    double* stage = &z[block(ocp) * k];
    stage[kDv] = u.v - before.v;
    stage[kDw] = u.w - before.w;
    before = u;
  }
}

}  // namespace

Iterate trajectory(const Ocp& ocp, const Forecast& motion) {
  Iterate guess;
  Twist2 moves = ocp.motion;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) {
    const Twist2& u = motion.twist[k];
    const Pose2& X = motion.X_MB[k + 1];
    guess.z.insert(guess.z.end(), {u.v, u.w, 0.0, 0.0, X.x, X.y, X.theta, 1e-3});
    if (!ocp.lag.any()) continue;
    moves = ocp.lag.end(moves, u);
    guess.z.insert(guess.z.end(), {moves.v, moves.w});
  }
  set_changes(ocp, guess.z);
  return guess;
}

Iterate cold_start(const Ocp& ocp, const Forecast& motion) {
  Iterate guess = trajectory(ocp, motion);
  set_slacks(ocp, guess.z);
  return guess;
}

Pose2 shifted_start(const Solved& last, double elapsed) {
  const Ocp& ocp = last.ocp;
  const int k = std::min(static_cast<int>(elapsed / ocp.dt), ocp.horizon() - 1);
  const double rest = std::clamp(elapsed - k * ocp.dt, 0.0, ocp.dt);
  const auto stage = static_cast<std::size_t>(k);
  const Moving before = moving_before(ocp, last.point.z, stage);
  return integrate(before.X_MB, ocp.lag.mean(before.twist, twist_of(ocp, last.point.z, stage)),
                   rest);
}

Forecast shifted_motion(const Solved& last, double elapsed, const Ocp& ocp) {
  const std::size_t stages = ocp.stages.size();
  const auto z = interpolate(last.point.z, last, elapsed, stages, block(ocp));
  // The measured heading is wrapped, the plan's is continuous. Stage 0 of both gives the offset.
  const double turns = std::round((last.ocp.X_MB.theta - ocp.X_MB.theta) / (2 * std::numbers::pi));
  Forecast out{{}, {ocp.X_MB}};
  Moving at{ocp.X_MB, ocp.motion};
  for (std::size_t k = 0; k < stages; ++k) {
    out.twist.push_back(twist_of(ocp, z, k));
    const bool beyond =
        static_cast<double>(k) + elapsed / ocp.dt > static_cast<double>(last.ocp.stages.size() - 1);
    const Twist2& u = out.twist.back();
    if (beyond) {
      at = advance(ocp, at, u);
    } else {
      at = {pose_after(ocp, z, k), ocp.lag.end(at.twist, u)};
      at.X_MB.theta -= turns * 2 * std::numbers::pi;
    }
    out.X_MB.push_back(at.X_MB);
  }
  return out;
}

Iterate warm_start(const Solved& last, double elapsed, const Ocp& ocp) {
  const std::size_t stages = ocp.stages.size();
  Iterate guess = cold_start(ocp, shifted_motion(last, elapsed, ocp));
  guess.lambda = interpolate(last.point.lambda, last, elapsed, stages, equalities(ocp));
  guess.lower = interpolate(last.point.lower, last, elapsed, stages, block(ocp));
  guess.upper = interpolate(last.point.upper, last, elapsed, stages, block(ocp));
  const auto first = first_pair_rows(last.ocp);
  for (std::size_t k = 0; k < stages; ++k) {
    const Between b = between(last, elapsed, k);
    const Pose2 X = pose_after(ocp, guess.z, k);
    const double slack = at(ocp, guess.z, k, kSlack);
    for (const Pair& pair : ocp.stages[k].pairs) {
      const double unmatched = -kBarrier / std::max(1e-3, clearance(pair, X) + slack);
      guess.lambda.push_back(b.of(multiplier(last, first, b.first, pair, unmatched),
                                  multiplier(last, first, b.second, pair, unmatched)));
    }
  }
  return guess;
}

}  // namespace tandem
