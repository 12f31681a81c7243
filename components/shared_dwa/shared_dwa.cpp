// SPDX-License-Identifier: Apache-2.0
#include "tandem/shared_dwa/shared_dwa.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kClearanceCap = 1.0;    // [m]
constexpr double kShortestStep = 0.015;  // [m] least travel of the outline between two map checks
constexpr double kRetreat = 1e-3;        // [m] allowed loss of clearance inside the margin

double square(double x) { return x * x; }

}  // namespace

SharedDwa::SharedDwa(const SharedDwaParams& params, const RobotParams& robot)
    : params_{params},
      robot_{robot},
      footprint_{footprint_of(robot)},
      radius_{circumradius(footprint_)} {
  check(params_);
  check(robot_);
}

DwaChoice SharedDwa::choose(const Pose2& X_MB, const Twist2& measured, const Twist2& user,
                            const StaticMap& map) const {
  DwaChoice best;
  best.clearance = map.clearance(footprint_, X_MB, kClearanceCap);
  best.admissible = false;
  const double delay = robot_.command_delay + robot_.sensor_delay + robot_.motor_lag;
  const Pose2 X_acting = integrate(X_MB, measured, delay);
  const double room = std::min(best.clearance, map.clearance(footprint_, X_acting, kClearanceCap));
  const double margin = std::min(params_.margin, room - kRetreat);
  for (const auto& [twist, disagreement] : samples(measured, limit(user, robot_))) {
    // Samples are sorted by disagreement, a lower bound of their cost: none of the rest can win.
    if (best.admissible && disagreement >= best.cost) break;
    const Arc arc = follow(X_acting, twist, margin, map);
    ++best.looked_at;
    if (!arc.admissible) continue;
    const double cost =
        disagreement + params_.weight_way * square(1.0 - arc.t_free / params_.horizon) +
        params_.weight_clearance * square(std::max(0.0, 1.0 - arc.clearance / params_.comfort));
    if (best.admissible && cost >= best.cost) continue;
    best.admissible = true;
    best.cost = cost;
    best.command = twist;
  }
  return best;
}

// The person's twist, rest (both clamped to the window) and the window's grid, sorted by
// disagreement.
std::vector<SharedDwa::Sample> SharedDwa::samples(const Twist2& measured,
                                                  const Twist2& user) const {
  const double dv = params_.window * robot_.a_brake, dw = params_.window * robot_.alpha_brake;
  const double v_low = std::clamp(measured.v - dv, robot_.v_min, robot_.v_max);
  const double v_high = std::clamp(measured.v + dv, robot_.v_min, robot_.v_max);
  const double w_low = std::clamp(measured.w - dw, -robot_.w_max, robot_.w_max);
  const double w_high = std::clamp(measured.w + dw, -robot_.w_max, robot_.w_max);
  const double v_scale = std::max(robot_.v_max, -robot_.v_min);
  std::vector<Sample> all;
  const auto add = [&](const Twist2& twist) {
    all.push_back({twist, params_.weight_v * square((twist.v - user.v) / v_scale) +
                              params_.weight_w * square((twist.w - user.w) / robot_.w_max)});
  };
  add({std::clamp(user.v, v_low, v_high), std::clamp(user.w, w_low, w_high)});
  add({std::clamp(0.0, v_low, v_high), std::clamp(0.0, w_low, w_high)});
  for (int i = 0; i < params_.v_samples; ++i)
    for (int j = 0; j < params_.w_samples; ++j)
      add({v_low + (v_high - v_low) * i / (params_.v_samples - 1),
           w_low + (w_high - w_low) * j / (params_.w_samples - 1)});
  std::stable_sort(all.begin(), all.end(), [](const Sample& a, const Sample& b) {
    return a.disagreement < b.disagreement;
  });
  return all;
}

// Conservative advancement: each step is as long as the clearance allows, but at least
// kShortestStep. Braking covers half the distance that the same time at full speed would.
SharedDwa::Arc SharedDwa::follow(const Pose2& X_MB, const Twist2& twist, double margin,
                                 const StaticMap& map) const {
  const double braking =
      std::max(std::abs(twist.v) / robot_.a_brake, std::abs(twist.w) / robot_.alpha_brake);
  const double to_rest = params_.control_period + 0.5 * braking;
  const double speed = std::abs(twist.v) + radius_ * std::abs(twist.w);
  Arc arc{params_.horizon, kClearanceCap, true};
  if (speed <= 0.0) {
    arc.clearance = map.clearance(footprint_, X_MB, kClearanceCap);
    return arc;
  }
  const double end = std::max(params_.horizon, to_rest);
  for (double t = 0.0;;) {
    const double c = map.clearance(footprint_, integrate(X_MB, twist, t), kClearanceCap);
    if (t <= to_rest) arc.clearance = std::min(arc.clearance, c);
    if (c < margin || c <= 0.0) {
      arc.t_free = std::min(t, params_.horizon);
      arc.admissible = t > to_rest;
      return arc;
    }
    if (t >= end) return arc;
    const double next = t + std::max(c - std::max(margin, 0.0), kShortestStep) / speed;
    t = t < to_rest && next > to_rest ? to_rest : std::min(next, end);
  }
}

}  // namespace tandem
