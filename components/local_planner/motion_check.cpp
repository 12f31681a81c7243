// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/motion_check.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/local_planner/ocp/signed_distance.hpp"

namespace tandem {
namespace {

constexpr double kSpacing = 0.01;         // [m] travel between two checks
constexpr double kRoundTolerance = 0.03;  // [m]
constexpr double kFar = 1e9;              // [m]

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

// An obstacle, and the total travel of body and obstacle before which they cannot touch.
struct Approach {
  Eigen::Vector2d axis;        // cosine and sine of the obstacle's angle
  double speed;                // [m/s]
  double clear_until = -kFar;  // [m]
};

std::vector<Approach> approaches(std::span<const Obstacle> obstacles) {
  std::vector<Approach> all;
  all.reserve(obstacles.size());
  for (const Obstacle& o : obstacles)
    all.push_back({{std::cos(o.angle), std::sin(o.angle)}, o.v_MO.norm()});
  return all;
}

// Lower bound of the distance between body and obstacle [m]: from circles around both, and where
// these overlap from the discs that cover the body.
double least_distance(const Body& body, double radius, const Pose2& X_MB, const Obstacle& obstacle,
                      const Eigen::Vector2d& axis) {
  constexpr double kSlop = 1e-9;  // [m] rounding
  const double apart = (obstacle.p_MO - X_MB.position()).norm() - circumradius(obstacle) - radius;
  if (apart > 0.0 || body.discs.empty()) return apart - kSlop;
  const double c = std::cos(X_MB.theta), s = std::sin(X_MB.theta);
  double least = kFar;
  for (const Disc& disc : body.discs) {
    const Eigen::Vector2d p_MC{X_MB.x + c * disc.p_BC.x() - s * disc.p_BC.y(),
                               X_MB.y + s * disc.p_BC.x() + c * disc.p_BC.y()};
    least = std::min(least, signed_distance(obstacle, axis, p_MC).value - disc.radius);
  }
  return least - kSlop;
}

// Whether the body touches one of the obstacles `t` [s] after their time, having moved by `way`
// [m].
bool touches_any(const Body& body, double radius, const Pose2& X_MB, double t, double way,
                 std::span<const Obstacle> obstacles, std::vector<Approach>& approaches) {
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    Approach& approach = approaches[i];
    const double moved = way + approach.speed * t;
    if (moved < approach.clear_until) continue;
    const Obstacle there = predicted(obstacles[i], t);
    const double distance = least_distance(body, radius, X_MB, there, approach.axis);
    if (distance <= 0.0 && touches(body, X_MB, there)) return true;
    approach.clear_until = moved + distance;
  }
  return false;
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
  if (!body.round) return overlaps(body.footprint, X_MB, obstacle);
  const Disc& disc = body.discs.front();
  return signed_distance(obstacle, transform(X_MB, disc.p_BC)).value <
         disc.radius - kRoundTolerance;
}

std::vector<Obstacle> passable(const Body& body, const Motion& motion,
                               std::span<const Obstacle> obstacles) {
  const double radius = reach(body);
  std::vector<Obstacle> out(obstacles.begin(), obstacles.end());
  for (Obstacle& obstacle : out) {
    const Obstacle now = predicted(obstacle, motion.start);
    if ((now.p_MO - motion.X_MB.position()).norm() > circumradius(now) + radius) continue;
    if (!touches(body, motion.X_MB, now)) continue;
    const double factor = std::max(1e-6, untouched_scale(body, motion.X_MB, now));
    obstacle = scaled(obstacle, factor);
  }
  return out;
}

bool is_clear(const Body& body, const Motion& motion, std::span<const Obstacle> obstacles,
              double duration) {
  const double radius = reach(body);
  std::vector<Approach> each = approaches(obstacles);
  Moving at{motion.X_MB, motion.moves};
  double t = 0.0, way = 0.0;  // way: bound of how far any point of the body has moved
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
      if (touches_any(body, radius, X_at, motion.start + t + s, way + travel * i / steps, obstacles,
                      each))
        return false;
    }
    at = follow(at, u, motion.lag, motion.dt);
    t += motion.dt;
    way += travel;
  }
  return true;
}

}  // namespace tandem
