// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/motion_check.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/local_planner/ocp/ellipse_distance.hpp"

namespace tandem {
namespace {

constexpr double kSpacing = 0.01;         // [m] travel between two checks
constexpr double kRoundTolerance = 0.03;  // [m]

double reach(const Body& body) {
  if (!body.round) return circumradius(body.footprint);
  return body.discs.front().p_BC.norm() + body.discs.front().radius;
}

Obstacle scaled(Obstacle obstacle, double factor) {
  obstacle.a *= factor;
  obstacle.b *= factor;
  return obstacle;
}

// Largest scale at which the obstacle is untouched, less 1 % against rounding in the first step.
double untouched_scale(const Body& body, const Pose2& X_MB, const Obstacle& obstacle) {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (low + high);
    (touches(body, X_MB, scaled(obstacle, middle)) ? high : low) = middle;
  }
  return 0.99 * low;
}

}  // namespace

double largest_radius(const Body& body) {
  double radius = 0.0;
  for (const Disc& disc : body.discs) radius = std::max(radius, disc.radius);
  return radius;
}

Obstacle predicted(const Obstacle& obstacle, double t) {
  Obstacle out = obstacle;
  out.p_MO += t * obstacle.v_MO;
  return out;
}

bool touches(const Body& body, const Pose2& X_MB, const Obstacle& obstacle) {
  if ((obstacle.p_MO - X_MB.position()).norm() > obstacle.a + reach(body)) return false;
  if (!body.round) return overlaps(body.footprint, X_MB, obstacle);
  const Disc& disc = body.discs.front();
  return signed_distance(obstacle, transform(X_MB, disc.p_BC)).value <
         disc.radius - kRoundTolerance;
}

std::vector<Obstacle> passable(const Body& body, const Motion& motion,
                               std::span<const Obstacle> obstacles) {
  std::vector<Obstacle> out(obstacles.begin(), obstacles.end());
  for (Obstacle& obstacle : out) {
    const Obstacle now = predicted(obstacle, motion.start);
    if (!touches(body, motion.X_MB, now)) continue;
    const double factor = std::max(1e-6, untouched_scale(body, motion.X_MB, now));
    obstacle = scaled(obstacle, factor);
  }
  return out;
}

bool is_clear(const Body& body, const Motion& motion, std::span<const Obstacle> obstacles,
              double duration) {
  const double radius = reach(body);
  Moving at{motion.X_MB, motion.moves};
  double t = 0.0;
  for (const Twist2& u : motion.twist) {
    const double held = std::min(motion.dt, duration - t);
    if (held <= 0.0) break;
    const Twist2& before = motion.lag.any() ? at.twist : u;
    const double v = std::max(std::abs(u.v), std::abs(before.v));
    const double w = std::max(std::abs(u.w), std::abs(before.w));
    const double travel = (v + radius * w) * held;
    const int steps = std::max(1, static_cast<int>(std::ceil(travel / kSpacing)));
    for (int i = 1; i <= steps; ++i) {
      const double s = held * i / steps;
      const Pose2 X_at = follow(at, u, motion.lag, s).X_MB;
      for (const Obstacle& obstacle : obstacles)
        if (touches(body, X_at, predicted(obstacle, motion.start + t + s))) return false;
    }
    at = follow(at, u, motion.lag, motion.dt);
    t += motion.dt;
  }
  return true;
}

}  // namespace tandem
