// SPDX-License-Identifier: Apache-2.0
#include "local_planner/close_approach.hpp"

#include <algorithm>
#include <cmath>

#include "model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kSpeed = 0.3;      // [m/s] of any point of the outline
constexpr double kAhead = 1.5;      // [s] over which plan and person are compared
constexpr double kBlocked = 0.5;    // share of the person's way that a plan in good order makes
constexpr double kBetter = 1.0;     // … from which on it is followed again
constexpr double kPatience = 0.3;   // [s] of plans that come to less
constexpr double kNear = 0.25;      // [m] between discs and obstacle
constexpr double kNoLonger = 0.35;  // [m] … from which on the planner takes over again

// The person's twist with its ratio kept, so slow that no point of the outline exceeds kSpeed.
Twist2 slowed(const Twist2& user, double radius) {
  const double fastest = std::abs(user.v) + radius * std::abs(user.w);
  const double scale = fastest > kSpeed ? kSpeed / fastest : 1.0;
  return {scale * user.v, scale * user.w};
}

double gap_at_start(const Cycle& cycle) {
  PairLimits here = cycle.limits;
  here.dt = 0.0;
  const auto gaps =
      clearances(cycle.body, cycle.request.obstacles, std::span(&cycle.start.X_MB, 1), here);
  return gaps.front() + cycle.limits.margin;
}

// How far a plan brings the robot after kAhead, as a share of the way of a constant twist: along
// that way, or in turning where the twist only turns.
double share_of_way(const Plan& plan, const Twist2& twist) {
  const Pose2& from = plan.X_MB.front();
  const Pose2 to = plan.pose_at(plan.t0 + kAhead);
  const Pose2 asked = integrate(from, twist, kAhead);
  const Eigen::Vector2d way = asked.position() - from.position();
  if (way.norm() > 0.05 * kAhead)
    return (to.position() - from.position()).dot(way) / way.squaredNorm();
  const double turn = kAhead * twist.w;
  return turn == 0.0 ? 1.0 : wrap_angle(to.theta - from.theta) / turn;
}

}  // namespace

std::optional<Twist2> CloseApproach::instead_of(const Plan& plan, const Cycle& cycle) {
  const PlanRequest& request = cycle.request;
  const double t = request.t;
  const bool steered = request.method != Method::kGoal && request.user != Twist2{};
  const Twist2 twist = slowed(request.user, circumradius(cycle.body.footprint));
  const bool possible = request.guarded && steered && !cycle.body.round &&
                        gap_at_start(cycle) < (approaches_ ? kNoLonger : kNear);
  const double least = approaches_ ? kBetter : kBlocked;
  if (!possible || share_of_way(plan, twist) >= least) {
    blocked_since_ = -1.0;
    approaches_ = false;
    return std::nullopt;
  }
  if (blocked_since_ < 0.0 || t < blocked_since_) blocked_since_ = t;
  approaches_ = approaches_ || t - blocked_since_ >= kPatience;
  return approaches_ ? std::optional{twist} : std::nullopt;
}

}  // namespace tandem
