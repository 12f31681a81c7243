// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/navigator.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tandem/driver/wander.hpp"

namespace tandem {
namespace {

constexpr double kAimTime = 2.0;          // [s] correlation time of the error across the route
constexpr double kArriveRadius = 0.3;     // [m] from the end, where the stick is released
constexpr double kBackOutShortest = 1.0;  // [s]
constexpr double kBackOutLongest = 4.0;   // [s] time for a leader to return from its maximum lead
constexpr double kBackOutDistance = 0.4;  // [m] first attempt; farther after each failure
constexpr double kBackOutFarthest = 1.2;  // [m]
constexpr double kGotPast = 0.5;          // [m] beyond the trouble at which the attempts are reset
constexpr double kDetourTime = 3.0;       // [s]
constexpr double kDetour = 0.5;           // [m] to the side, `preview` ahead
constexpr double kMovedDistance = 0.1;    // [m]
constexpr double kMovedAngle = 0.35;      // [rad]
constexpr double kSearchAhead = 2.0;      // [m] maximum progress per sample
constexpr double kAtPoint = 0.15;         // [m] points nearer than this are not aimed at
constexpr double kBesideLeader = 0.3;     // [m] a robot this near has reached its leader

bool pushes(const Hand& hand) {
  return std::abs(hand.linear) > 0.2 || std::abs(hand.angular) > 0.2;
}

bool has_reached(const Pose2& X_ML, const Eigen::Vector2d& p_MT) {
  const Eigen::Vector2d ahead{std::cos(X_ML.theta), std::sin(X_ML.theta)};
  const Eigen::Vector2d to = p_MT - X_ML.position();
  return ahead.dot(to) <= 0.0 || to.norm() < kAtPoint;
}

// A leader that has reached its target point, or passed it, waits there for the robot. Once the
// robot has arrived, a target that is still behind means that the leader faces the wrong way, so it
// is turned round.
bool waits_for(const Pose2& X_MB, const Pose2& X_ML, const Eigen::Vector2d& p_MT) {
  return has_reached(X_ML, p_MT) && (X_MB.position() - X_ML.position()).norm() > kBesideLeader;
}

}  // namespace

Navigator::Navigator(const NavigatorParams& params, unsigned seed)
    : params_{params}, random_{seed} {
  check(params_);
  if (params_.route.empty() || params_.route.size() % 2 != 0)
    throw std::invalid_argument("route: expected points x1, y1, x2, y2, …");
  for (std::size_t i = 0; i < params_.route.size(); i += 2)
    route_.emplace_back(params_.route[i], params_.route[i + 1]);
  if (params_.loop) route_.push_back(route_.front());
  length_.push_back(0.0);
  for (std::size_t i = 1; i < route_.size(); ++i)
    length_.push_back(length_.back() + (route_[i] - route_[i - 1]).norm());
}

Hand Navigator::steer(const Pose2& X_MB, const Pose2& X_MS, double t) {
  if (!started_) {
    moved_ = {X_MB, t};
    started_ = true;
  }
  advance_along_route(X_MB.position());
  seen_.push_back({X_MS, t});
  while (seen_.size() > 1 && seen_[1].t <= t - params_.reaction_delay) seen_.pop_front();
  if (!params_.loop && (route_.back() - X_MB.position()).norm() < kArriveRadius) arrived_ = true;
  if (arrived_) return {};

  sideways_ = wandered(sideways_, params_.aim_noise, kAimTime);
  if (backs_out(X_MB, t)) return with_noise(reverse(seen_.front().value));
  const bool leads = !(X_MS == X_MB);
  const Eigen::Vector2d p_MT = aim(X_MB.position());
  const bool waits = leads && waits_for(X_MB, seen_.front().value, p_MT);
  const Hand hand =
      waits ? look_along_route(seen_.front().value) : with_noise(pursue(seen_.front().value, p_MT));
  if (t >= detour_until_) detour_ = 0.0;
  lose_patience(X_MB, waits || pushes(hand), t);
  return hand;
}

void Navigator::start_again() {
  started_ = arrived_ = backing_out_ = false;
  progress_ = trouble_ = detour_ = 0.0;
  tries_ = 0;
}

// Advances to the nearest point of the route, searching only forward: a person remembers how far
// they have come, even where the route passes the same place twice.
void Navigator::advance_along_route(const Eigen::Vector2d& p_MB) {
  const double total = length_.back();
  double best = progress_, best_distance = (point_at(progress_) - p_MB).norm();
  for (double s = progress_; s <= progress_ + kSearchAhead; s += 0.05) {
    const double d = (point_at(s) - p_MB).norm();
    if (d < best_distance) {
      best = s;
      best_distance = d;
    }
  }
  progress_ = params_.loop ? best : std::min(best, total);
  if (progress_ > trouble_ + kGotPast) tries_ = 0;
}

Eigen::Vector2d Navigator::point_at(double s) const {
  const double total = length_.back();
  if (total <= 0.0) return route_.front();
  s = params_.loop ? std::fmod(s, total) : std::clamp(s, 0.0, total);
  const auto next = std::upper_bound(length_.begin(), length_.end() - 1, s);
  const auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, next - length_.begin()));
  const double share = (s - length_[i - 1]) / std::max(1e-9, length_[i] - length_[i - 1]);
  return route_[i - 1] + share * (route_[i] - route_[i - 1]);
}

Eigen::Vector2d Navigator::aim(const Eigen::Vector2d& p_MB) const {
  if (!has_route()) return aim_at_goal(p_MB);
  // After a failure the person cuts corners less.
  const Eigen::Vector2d target = point_at(progress_ + params_.preview / (1.0 + 0.5 * tries_));
  const Eigen::Vector2d along = target - point_at(progress_);
  if (along.norm() < 1e-6) return target;
  const Eigen::Vector2d left = Eigen::Vector2d{-along.y(), along.x()}.normalized();
  return target + (sideways_ / (1.0 + tries_) + detour_) * left;
}

// Straight at the goal or, after a failure, beside the straight line.
Eigen::Vector2d Navigator::aim_at_goal(const Eigen::Vector2d& p_MB) const {
  const Eigen::Vector2d sight = route_.back() - p_MB;
  if (detour_ == 0.0 || sight.norm() < params_.preview) return route_.back();
  const Eigen::Vector2d ahead = sight.normalized();
  return p_MB + params_.preview * ahead + detour_ * Eigen::Vector2d{-ahead.y(), ahead.x()};
}

Hand Navigator::pursue(const Pose2& X_MS, const Eigen::Vector2d& p_MT) const {
  const Eigen::Vector2d d = p_MT - X_MS.position();
  const double bearing = wrap_angle(std::atan2(d.y(), d.x()) - X_MS.theta);
  const double slow = d.norm() < 0.5 ? d.norm() / 0.5 : 1.0;
  const double forward = std::max(0.0, std::cos(std::clamp(bearing, -1.5, 1.5)));
  return {params_.speed * slow * forward * forward,
          std::clamp(NavigatorParams::kTurnGain * bearing, -1.0, 1.0)};
}

// The leader's heading is the one that the robot is to take.
Hand Navigator::look_along_route(const Pose2& X_MS) const {
  const double s = progress_ + params_.preview;
  const Eigen::Vector2d along = point_at(s + 0.2) - point_at(s - 0.2);
  const double bearing = wrap_angle(std::atan2(along.y(), along.x()) - X_MS.theta);
  return {0.0, std::clamp(NavigatorParams::kTurnGain * bearing, -1.0, 1.0)};
}

// Reverses toward the route, where it was clear.
Hand Navigator::reverse(const Pose2& X_MS) const {
  const Eigen::Vector2d d = point_at(progress_) - X_MS.position();
  const double bearing = wrap_angle(std::atan2(-d.y(), -d.x()) - X_MS.theta);
  if (tries_ % 2 == 1 || std::abs(bearing) > 1.2) return {-0.7, back_out_turn_};
  return {-0.7, std::clamp(NavigatorParams::kTurnGain * bearing, -0.5, 0.5)};
}

Hand Navigator::with_noise(Hand hand) {
  hand_linear_ = wandered(hand_linear_, params_.stick_noise, 0.3);
  hand_angular_ = wandered(hand_angular_, params_.stick_noise, 0.3);
  return {std::clamp(hand.linear + hand_linear_, -1.0, 1.0),
          std::clamp(hand.angular + hand_angular_, -1.0, 1.0)};
}

// After pushing without moving for `patience`, people pull back, turn a little and try another
// side. Those who know a route keep to it after two failures.
void Navigator::lose_patience(const Pose2& X_MB, bool wants_to_move, double t) {
  const bool moved = (X_MB.position() - moved_.value.position()).norm() > kMovedDistance ||
                     std::abs(wrap_angle(X_MB.theta - moved_.value.theta)) > kMovedAngle;
  if (moved || !wants_to_move) {
    moved_ = {X_MB, t};
    return;
  }
  if (moved_.age(t) < params_.patience) return;
  const double side = normal_(random_) > 0.0 ? 1.0 : -1.0;
  back_out_turn_ = -0.4 * side;
  detour_ = tries_ < 2 || !has_route() ? kDetour * side : 0.0;
  back_out_from_ = X_MB;
  back_out_start_ = t;
  backing_out_ = true;
  trouble_ = std::max(trouble_, progress_);
  ++tries_;
}

double Navigator::back_out_distance() const {
  return tries_ % 2 == 1 ? kBackOutDistance : std::min(kBackOutFarthest, kBackOutDistance * tries_);
}

// Whether to keep backing out: until the robot has moved back far enough, or backing out does not
// help either.
bool Navigator::backs_out(const Pose2& X_MB, double t) {
  if (!backing_out_) return false;
  const double age = t - back_out_start_;
  const double moved = (X_MB.position() - back_out_from_.position()).norm();
  backing_out_ = age < kBackOutShortest || (age < kBackOutLongest && moved < back_out_distance());
  if (backing_out_) return true;
  if (tries_ % 2 == 0) progress_ = std::max(0.0, progress_ - back_out_distance());
  detour_until_ = t + kDetourTime;
  moved_ = {X_MB, t};
  return false;
}

double Navigator::wandered(double value, double deviation, double time) {
  return wander(value, deviation, time, params_.rate, normal_(random_));
}

}  // namespace tandem
