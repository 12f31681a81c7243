// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/close_approach.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kSpeed = 0.5;  // [m/s]
constexpr double kTurn = 0.8;   // [rad/s]
constexpr double kSpot = 0.15;  // [m] an arc of smaller radius is a turn on the spot
constexpr double kLever = 0.5;  // [m] converts a turn rate to a speed for comparison
constexpr double kSoon = 1.0;   // [s]
constexpr double kQuarterTurn = 0.5 * std::numbers::pi;
constexpr double kBlocked = 0.15;   // a plan that covers a smaller share of the way is blocked
constexpr double kHeldBack = 0.7;   // the same, of the first second of a slow approach
constexpr double kFree = 0.8;       // a plan that covers a larger share is followed again
constexpr double kStands = 0.1;     // [m/s], [rad/s] slower than this counts as standing
constexpr double kSlow = 0.35;      // [m/s] slower than this it stands before kPatience is over
constexpr double kPatience = 0.3;   // [s] of blocked plans before the person's twist is used
constexpr double kStraight = 0.5;   // [1/m] largest curvature that counts as straight
constexpr double kGivesUp = 5.0;    // [s] of pushing while standing
constexpr double kElsewhere = 0.5;  // [m] from where the person gave up
constexpr double kNear = 0.35;      // [m] gap between discs and obstacle that allows an approach
constexpr double kNoLonger = 0.45;  // [m] gap at which the planner takes over again

bool turns_on_spot(const Twist2& twist) { return std::abs(twist.v) < kSpot * std::abs(twist.w); }

// Keeps w / v, so that the robot stays on the commanded arc.
Twist2 slowed(const Twist2& twist) {
  const double times = std::max({1.0, std::abs(twist.v) / kSpeed, std::abs(twist.w) / kTurn});
  return {twist.v / times, twist.w / times};
}

double gap_at_start(const Cycle& cycle) {
  PairLimits here = cycle.limits;
  here.dt = 0.0;
  const auto gaps =
      clearances(cycle.body, cycle.request.obstacles, std::span(&cycle.start.X_MB, 1), here);
  return gaps.front() + cycle.limits.margin;
}

// Progress of the plan over `time` [s], as a share of the displacement (or of the turn on the spot)
// that `twist` would produce. Capped at a quarter turn, beyond which the comparison means little.
double share_of_way(const Plan& plan, const Twist2& twist, double time) {
  time = std::min(time, kQuarterTurn / std::max(1e-9, std::abs(twist.w)));
  const Pose2 &from = plan.X_MB.front(), to = plan.pose_at(plan.t0 + time);
  if (turns_on_spot(twist)) return (to.theta - from.theta) / (twist.w * time);
  const Eigen::Vector2d way = integrate(from, twist, time).position() - from.position();
  return (to.position() - from.position()).dot(way) / way.squaredNorm();
}

// A plan that follows a leader may leave the stick's direction for a while, so it counts as blocked
// only if the robot is about to stand or drives the other way. A plan that follows the stick, or
// turns on the spot, may postpone its progress cycle after cycle, so for a standing robot the first
// second is checked as well. The former also brakes far earlier than a person does who drives up to
// something slowly, because its cost spreads the braking over the horizon.
bool is_blocked(const Plan& plan, const Twist2& twist, const Cycle& cycle) {
  const double v = cycle.request.measured.v, ahead = twist.v < 0.0 ? -v : v;
  const bool for_good =
      share_of_way(plan, twist, cycle.params.dt * cycle.params.horizon_steps) < kBlocked;
  const bool follows = cycle.request.method != Method::kIntention && !turns_on_spot(twist);
  if (follows) return ahead < kSlow && for_good;
  const double soon = share_of_way(plan, twist, kSoon);
  const bool slow =
      !turns_on_spot(twist) && std::abs(cycle.request.user.v) < kSpeed && ahead < kSpeed;
  return for_good || (slow && soon < kHeldBack) || (std::abs(v) < kStands && soon < kBlocked);
}

bool is_free(const Plan& plan, const Twist2& twist, const Cycle& cycle) {
  return share_of_way(plan, twist, kSoon) > kFree &&
         share_of_way(plan, twist, cycle.params.dt * cycle.params.horizon_steps) > kFree;
}

// A person who steers wants to get past the obstacle, not closer to it.
bool is_straight(const Twist2& twist) {
  return turns_on_spot(twist) || std::abs(twist.w) < kStraight * std::abs(twist.v);
}

bool is_opposite(const Twist2& a, const Twist2& b) {
  return a.v * b.v + kLever * kLever * a.w * b.w < 0.0;
}

bool is_possible(const Cycle& cycle, double near) {
  const PlanRequest& request = cycle.request;
  const bool steered = request.method != Method::kGoal && request.user != Twist2{};
  return request.guarded && steered && !cycle.body.round && gap_at_start(cycle) < near;
}

}  // namespace

std::optional<Twist2> CloseApproach::instead_of(const Plan& plan, const Cycle& cycle) {
  const PlanRequest& request = cycle.request;
  const Twist2 twist = slowed(request.user);
  const bool possible = is_possible(cycle, approaches_ ? kNoLonger : kNear);
  const bool turned_back = approaches_ && is_opposite(twist, last_);
  const bool in_vain = in_vain_.holds(approaches_, request);
  if (!possible || turned_back || in_vain) {
    approaches_ = false;
    blocked_since_ = -1.0;
    return std::nullopt;
  }
  const bool blocked = approaches_ ? !is_free(plan, twist, cycle)
                                   : is_straight(twist) && is_blocked(plan, twist, cycle);
  if (!blocked) blocked_since_ = -1.0;
  if (blocked && (blocked_since_ < 0.0 || request.t < blocked_since_)) blocked_since_ = request.t;
  approaches_ = blocked && (approaches_ || request.t - blocked_since_ >= kPatience);
  last_ = twist;
  return approaches_ ? std::optional{twist} : std::nullopt;
}

bool InVain::holds(bool approaches, const PlanRequest& request) {
  const Eigen::Vector2d p_MB = request.X_MB.position();
  if (gave_up_at_ && ((p_MB - *gave_up_at_).norm() > kElsewhere || request.user == Twist2{}))
    gave_up_at_.reset();
  const bool stands =
      std::abs(request.measured.v) < kStands && std::abs(request.measured.w) < kStands;
  if (!approaches || !stands || request.t < standing_since_) standing_since_ = request.t;
  if (request.t - standing_since_ >= kGivesUp) gave_up_at_ = p_MB;
  return gave_up_at_.has_value();
}

}  // namespace tandem
