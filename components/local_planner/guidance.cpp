// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/guidance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tandem {
namespace {

using Eigen::Vector2d;

struct Nearest {
  Vector2d p_MQ;
  double distance;
  double direction;  // of the line there [rad]
};

Nearest nearest_on(const Vector2d& from, const Vector2d& to, const Vector2d& p) {
  const Vector2d edge = to - from;
  const double length2 = edge.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp((p - from).dot(edge) / length2, 0.0, 1.0) : 0.0;
  const Vector2d p_MQ = from + s * edge;
  return {p_MQ, (p - p_MQ).norm(), std::atan2(edge.y(), edge.x())};
}

Nearest nearest_on(const GuidanceLine& line, const Vector2d& p) {
  Nearest best = nearest_on(line.p_MV[0], line.p_MV[1], p);
  for (std::size_t i = 2; i < line.p_MV.size(); ++i) {
    const Nearest other = nearest_on(line.p_MV[i - 1], line.p_MV[i], p);
    if (other.distance < best.distance) best = other;
  }
  return best;
}

}  // namespace

Pose2 guided(const Pose2& X_M, std::span<const GuidanceLine> lines) {
  constexpr double kCrossing = std::numbers::pi / 3.0;  // [rad] from here on the line has no effect
  Pose2 out = X_M;
  double strongest = 0.0;
  for (const GuidanceLine& line : lines) {
    const Nearest q = nearest_on(line, X_M.position());
    if (q.distance >= line.reach) continue;
    double turn = wrap_angle(q.direction - X_M.theta);
    if (std::abs(turn) > 0.5 * std::numbers::pi) turn = wrap_angle(turn + std::numbers::pi);
    if (std::abs(turn) >= kCrossing) continue;
    const double near = 1.0 - std::pow(q.distance / line.reach, 2);
    const double s = line.strength * near * near * std::pow(std::cos(1.5 * turn), 2);
    if (s <= strongest) continue;
    strongest = s;
    const Vector2d p = X_M.position() + s * (q.p_MQ - X_M.position());
    out = {p.x(), p.y(), X_M.theta + s * turn};
  }
  return out;
}

}  // namespace tandem
