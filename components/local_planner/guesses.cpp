// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/guesses.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tandem/local_planner/ocp/signed_distance.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

struct Blocker {
  Eigen::Vector2d p_MO;
  double t;                 // after the obstacles' time [s]
  Eigen::Vector2d heading;  // of the nominal trajectory there
};

std::optional<Blocker> first_blocker(const Forecast& nominal, const Body& body,
                                     std::span<const Obstacle> obstacles,
                                     const PairLimits& limits) {
  const auto poses = std::span(nominal.X_MB).subspan(1);
  const std::size_t k = first_miss(body, obstacles, poses, limits);
  if (k == poses.size()) return std::nullopt;
  PairLimits there = limits;
  there.start += limits.dt * static_cast<double>(k);
  const auto pairs = nearest_pairs(body, obstacles, poses.subspan(k, 1), there);
  const Pair& pair = pairs.front().front();
  const Eigen::Vector2d p_MC = transform(poses[k], pair.p_BC);
  const auto phi = signed_distance(pair.obstacle, p_MC);
  const double theta = poses[k].theta;
  return Blocker{p_MC - phi.value * phi.normal, there.start, {std::cos(theta), std::sin(theta)}};
}

bool is_free(const Eigen::Vector2d& p_MQ, double gap, double t,
             std::span<const Obstacle> obstacles) {
  const Body disc{{}, {{{0.0, 0.0}, gap}}, true};
  const Pose2 X_MQ{p_MQ.x(), p_MQ.y(), 0.0};
  return first_miss(disc, obstacles, std::span(&X_MQ, 1), {.margin = 0.0, .start = t, .dt = 0.0}) ==
         1;
}

// The first `stages` of the motion, then braking.
Forecast stopped_after(std::size_t stages, const Forecast& motion, double dt,
                       const RobotParams& robot) {
  Forecast out = motion;
  for (std::size_t k = stages; k < motion.twist.size(); ++k) {
    const Twist2& before = out.twist[k == 0 ? 0 : k - 1];
    if (k > 0)
      out.twist[k] = {approach(before.v, 0.0, robot.a_max * dt),
                      approach(before.w, 0.0, robot.alpha_max * dt)};
    out.X_MB[k + 1] = integrate(out.X_MB[k], out.twist[k], dt);
  }
  return out;
}

}  // namespace

Forecast stopped_in_time(const Forecast& motion, const Body& body,
                         std::span<const Obstacle> obstacles, const PairLimits& limits,
                         const RobotParams& robot) {
  Forecast out = motion;
  const std::size_t first = first_miss(body, obstacles, std::span(out.X_MB).subspan(1), limits);
  if (first == motion.twist.size()) return out;
  for (std::size_t stages = first;; --stages) {
    out = stopped_after(stages, motion, limits.dt, robot);
    PairLimits later = limits;  // earlier poses are unchanged and known to be clear
    later.start += limits.dt * static_cast<double>(stages);
    const auto changed = std::span(out.X_MB).subspan(1 + stages);
    if (stages == 0 || first_miss(body, obstacles, changed, later) == changed.size()) return out;
  }
}

std::vector<Eigen::Vector2d> points_beside(const Forecast& nominal, const Body& body,
                                           std::span<const Obstacle> obstacles,
                                           const PairLimits& limits) {
  std::vector<Eigen::Vector2d> points;
  const auto blocker = first_blocker(nominal, body, obstacles, limits);
  if (!blocker) return points;
  const double radius = largest_radius(body);
  const Eigen::Vector2d way = blocker->p_MO - nominal.X_MB.front().position();
  const Eigen::Vector2d ahead = way.norm() > 0.2 ? way.normalized() : blocker->heading;
  const Eigen::Vector2d left{-ahead.y(), ahead.x()};
  for (const double side : {1.0, -1.0})
    for (double offset = 0.1; offset <= 3.0; offset += 0.1) {
      const Eigen::Vector2d p_MV = blocker->p_MO + side * offset * left;
      if (!is_free(p_MV, radius + limits.margin + 0.05, blocker->t, obstacles)) continue;
      points.push_back(p_MV);
      break;
    }
  return points;
}

bool is_alike(const Forecast& guess, const Forecast& motion, const Body& body,
              std::span<const Obstacle> obstacles, const PairLimits& limits) {
  constexpr double kTurned = 1.2;    // [rad] larger differences of heading are another manoeuvre
  constexpr double kReverse = 0.05;  // [m/s] slower motions have no direction
  const auto direction = [](double v) { return v > kReverse ? 1 : v < -kReverse ? -1 : 0; };
  for (std::size_t k = 0; k < guess.twist.size(); ++k)
    if (direction(guess.twist[k].v) * direction(motion.twist[k].v) < 0 ||
        std::abs(guess.X_MB[k + 1].theta - motion.X_MB[k + 1].theta) > kTurned)
      return false;
  PairLimits touching = limits;
  touching.margin = touching.moving = 0.0;
  std::vector<Pose2> between(guess.twist.size());
  for (const double r : {0.25, 0.5, 0.75}) {
    for (std::size_t k = 0; k < between.size(); ++k) {
      const Pose2 &a = guess.X_MB[k + 1], &b = motion.X_MB[k + 1];
      between[k] = {a.x + r * (b.x - a.x), a.y + r * (b.y - a.y),
                    a.theta + r * (b.theta - a.theta)};
    }
    if (first_miss(body, obstacles, between, touching) < between.size()) return false;
  }
  return true;
}

bool is_stuck(Method method, const Forecast& nominal, const Eigen::Vector2d& target,
              const Forecast& motion, double horizon, const RobotParams& robot) {
  constexpr double kProgress = 0.6;  // a motion that covers a smaller share of the way is stuck
  constexpr double kAble = 0.3;      // mean speed over v_max, allowing for a turn on the spot first
  const Eigen::Vector2d from = motion.X_MB.front().position(), to = motion.X_MB.back().position();
  if (method == Method::kIntention) {
    const Eigen::Vector2d way = nominal.X_MB.back().position() - from;
    return way.norm() > 0.3 && (to - from).dot(way) < kProgress * way.squaredNorm();
  }
  const double way = (target - from).norm(), rest = (target - to).norm();
  return way > 0.3 && way - rest < kProgress * std::min(way, kAble * robot.v_max * horizon);
}

}  // namespace tandem
