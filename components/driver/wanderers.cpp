// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/wanderers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace tandem {
namespace {

constexpr double kTurnGain = 2.0;            // [1/rad] stick per bearing error
constexpr double kShortestBearing = 0.5;     // [s] minimum duration of one bearing
constexpr double kLongestBearing = 3.0;      // [s]
constexpr double kSight = 3.0;               // [m] range within which an adversary sees obstacles
constexpr double kPushing = 3.0;             // [s] blocked for this long before the next run-up
constexpr double kRunUp = 3.0;               // [s]
constexpr double kUnblockedDistance = 0.05;  // [m]
constexpr double kUnblockedAngle = 0.2;      // [rad]
constexpr double kRestOfReplay = 0.1;        // [s] duration of the last sample

// Full speed toward a bearing in M; reverses if it lies behind.
Hand rush(const Pose2& X_MS, double bearing) {
  const double ahead = wrap_angle(bearing - X_MS.theta);
  const bool back = std::abs(ahead) > 0.5 * std::numbers::pi;
  const double error = back ? wrap_angle(ahead + std::numbers::pi) : ahead;
  return {back ? -1.0 : 1.0, std::clamp(kTurnGain * error, -1.0, 1.0)};
}

double any_bearing(std::mt19937& random) {
  return std::uniform_real_distribution<double>(-std::numbers::pi, std::numbers::pi)(random);
}

}  // namespace

Pointer::Pointer(const NavigatorParams& params, unsigned seed) : loop_{params.loop} {
  const auto& route = params.route;
  NavigatorParams leg = params;
  leg.loop = false;
  for (std::size_t i = loop_ ? 0 : route.size() - std::min<std::size_t>(2, route.size());
       i + 1 < route.size(); i += 2) {
    leg.route = {route[i], route[i + 1]};
    legs_.emplace_back(leg, seed + static_cast<unsigned>(i));
  }
  if (legs_.empty() || route.size() % 2 != 0)
    throw std::invalid_argument("route: expected points x1, y1, x2, y2, …");
}

Hand Pointer::steer(const Pose2& X_MB, const Pose2& X_MS, double t) {
  Hand hand = legs_[leg_].steer(X_MB, X_MS, t);
  if (!loop_ || !legs_[leg_].arrived()) return hand;
  leg_ = (leg_ + 1) % legs_.size();
  legs_[leg_].start_again();
  return legs_[leg_].steer(X_MB, X_MS, t);
}

Hand Reckless::steer(const Pose2& X_MS, double t) {
  if (!started_) start_ = t;
  started_ = true;
  arrived_ = arrived_ || t - start_ >= time_;
  if (arrived_) return {0.0, 0.0, false};
  if (t >= until_) {
    bearing_ = any_bearing(random_);
    until_ = t + std::uniform_real_distribution<double>(kShortestBearing, kLongestBearing)(random_);
  }
  return rush(X_MS, bearing_);
}

Hand Adversary::steer(const Pose2& X_MB, const Pose2& X_MS, const StaticMap* map, double t) {
  const bool moved = (X_MB.position() - moved_.value.position()).norm() > kUnblockedDistance ||
                     std::abs(wrap_angle(X_MB.theta - moved_.value.theta)) > kUnblockedAngle;
  if (moved || moved_.t == Stamped<Pose2>::kNever) moved_ = {X_MB, t};
  if (moved_.age(t) > kPushing) {
    bearing_ = any_bearing(random_);
    run_up_until_ = moved_.t = t + kRunUp;
  }
  if (t < run_up_until_) return rush(X_MS, bearing_);
  if (!map) return {1.0, 0.0};
  double nearest = kSight;
  double bearing = X_MS.theta;
  for (const auto& p_MC : map->cells_near(X_MB.position(), kSight)) {
    const double d = (p_MC - X_MB.position()).norm();
    if (d >= nearest) continue;
    nearest = d;
    const Eigen::Vector2d to = p_MC - X_MS.position();
    bearing = std::atan2(to.y(), to.x());
  }
  return rush(X_MS, bearing);
}

Replay::Replay(Recording recording) : recording_{std::move(recording)} {
  const auto& r = recording_;
  if (r.t.empty() || r.linear.size() != r.t.size() || r.angular.size() != r.t.size())
    throw std::invalid_argument("replay: needs equal numbers of times, linear and angular samples");
  if (!std::is_sorted(r.t.begin(), r.t.end()))
    throw std::invalid_argument("replay: its times must not decrease");
}

Hand Replay::steer(double t) {
  if (!started_) start_ = t;
  started_ = true;
  const auto& r = recording_;
  const double age = t - start_ + r.t.front() + 1e-9;
  arrived_ = arrived_ || age > r.t.back() + kRestOfReplay;
  if (arrived_) return {0.0, 0.0, false};
  const auto next = std::upper_bound(r.t.begin(), r.t.end(), age);
  const auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, next - r.t.begin() - 1));
  return {r.linear[i], r.angular[i]};
}

}  // namespace tandem
