// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/clearance_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

constexpr double kLookAhead = 0.08;  // [m] measured beyond the requirement, to skip later checks
constexpr double kEnough = 0.02;     // [m] from this lower bound on, no exact measurement is needed
constexpr double kShortLookAhead = 0.02;  // [m] the same as kLookAhead when measured cell by cell
constexpr double kDifference = 1e-6;      // [m] step of the central difference for a direction
constexpr double kRounding = 1e-6;        // [m] tolerance of g · u_i against gap_i at the start
constexpr double kInset = 0.005;          // [m] step by which an outline is shrunk
constexpr double kNone = -1e9;            // [m] no slack

// Unit vector from the outline to a square. Moving the outline that way reduces the gap by the full
// distance moved.
Eigen::Vector2d direction_to(const Eigen::Vector2d& p_MC, double side, const Pose2& X_MB,
                             const Footprint& footprint) {
  const auto gap = [&](double dx, double dy) {
    return distance_to_square(footprint, {X_MB.x + dx, X_MB.y + dy, X_MB.theta}, p_MC, side);
  };
  const Eigen::Vector2d slope{gap(-kDifference, 0.0) - gap(kDifference, 0.0),
                              gap(0.0, -kDifference) - gap(0.0, kDifference)};
  return slope.normalized();
}

// Slack of the square around p_MC in (1), for the near cell that allows the most [m].
double slack_behind(const std::vector<NearCell>& near, const Footprint& footprint,
                    const Eigen::Vector2d& p_MC, const Pose2& X_MB, const StaticMap& map,
                    double deviation) {
  const double side = map.grid().resolution;
  const double gap = distance_to_square(footprint, X_MB, p_MC, side);
  if (gap <= kDifference) return kNone;
  const Eigen::Vector2d g_M = gap * direction_to(p_MC, side, X_MB, footprint);
  double slack = kNone;
  for (const NearCell& cell : near)
    slack = std::max(slack, g_M.dot(cell.u_M) - cell.gap - deviation + kRounding);
  return slack;
}

NearCell see(const Eigen::Vector2d& p_MC, double side, const Pose2& X_MB,
             const Footprint& footprint) {
  return {direction_to(p_MC, side, X_MB, footprint),
          distance_to_square(footprint, X_MB, p_MC, side)};
}

// The extremes of the pose's error, without those in which the outline overlaps a cell: the robot
// is not there.
std::vector<PossiblePose> possible_poses(const Pose2& X_MB, double position_error,
                                         double heading_error, const Footprint& footprint,
                                         const std::vector<Eigen::Vector2d>& close, double side) {
  std::vector<PossiblePose> all;
  for (const double turned : {-heading_error, heading_error})
    for (const auto& [x, y] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}}) {
      PossiblePose possible;
      possible.X_MB = compose(X_MB, {position_error * x, position_error * y, turned});
      possible.X_NM = compose(possible.X_MB, inverse(X_MB));
      bool clear = true;
      for (const auto& p_MC : close) {
        possible.near.push_back(see(p_MC, side, possible.X_MB, footprint));
        clear = clear && possible.near.back().gap > kDifference;
      }
      if (clear) all.push_back(std::move(possible));
    }
  return all;
}

// The outline shrunk until it overlaps none of the squares; without parts if it always does.
Footprint inset_until_clear(const Footprint& footprint, const Pose2& X_MB,
                            const std::vector<Eigen::Vector2d>& squares, double side) {
  for (int i = 1;; ++i) {
    Footprint result = inset(footprint, i * kInset);
    const bool clear = std::all_of(squares.begin(), squares.end(), [&](const auto& p_MC) {
      return distance_to_square(result, X_MB, p_MC, side) > kDifference;
    });
    if (clear || result.parts.empty()) return result;
  }
}

// Slack of the square around p_MC if the robot started at that possible pose (PossiblePose) [m].
double slack_from(const PossiblePose& possible, const Footprint& footprint,
                  const Eigen::Vector2d& p_MC, const Pose2& X_MB, double side) {
  const Pose2 X_NB = compose(possible.X_NM, X_MB);
  const double gap = distance_to_square(footprint, X_NB, p_MC, side);
  const double at_start = distance_to_square(footprint, possible.X_MB, p_MC, side);
  double slack = gap - at_start + kRounding;
  if (slack >= 0.0 || gap <= kDifference) return slack;
  const Eigen::Vector2d g_M = gap * direction_to(p_MC, side, X_NB, footprint);
  for (const NearCell& cell : possible.near)
    slack = std::max(slack, g_M.dot(cell.u_M) - cell.gap + kRounding);
  return slack;
}

// Slack of a square that is nearer than the level, for a motion that starts inside it [m].
double slack_inside(const Eigen::Vector2d& p_MC, const Pose2& X_MB, const BoundedFootprint& body,
                    const StaticMap& map, const RequiredClearance& required, double deviation) {
  double slack = slack_behind(required.near, body.footprint, p_MC, X_MB, map, deviation);
  if (slack < 0.0 && !required.overlapped.empty())
    slack = slack_behind(required.overlapped, required.inset, p_MC, X_MB, map, deviation);
  for (const PossiblePose& possible : required.possible) {
    if (slack < 0.0) break;
    slack =
        std::min(slack, slack_from(possible, body.footprint, p_MC, X_MB, map.grid().resolution));
  }
  return slack;
}

// Clearance in hand at a pose, computed cell by cell, for a motion that starts inside the level
// [m].
double in_hand_near(const Pose2& X_MB, const BoundedFootprint& body, const StaticMap& map,
                    const RequiredClearance& required, double deviation) {
  const double need = required.level + deviation, side = map.grid().resolution;
  double in_hand = kShortLookAhead;
  for (const auto& p_MC : map.squares_near(X_MB.position(), body.radius + need + kShortLookAhead)) {
    double slack = distance_to_square(body.footprint, X_MB, p_MC, side) - need;
    if (slack < 0.0) slack = slack_inside(p_MC, X_MB, body, map, required, deviation);
    in_hand = std::min(in_hand, slack);
    if (in_hand < 0.0) break;
  }
  return in_hand;
}

double in_hand_at(const Pose2& X_MB, const BoundedFootprint& body, const StaticMap& map,
                  const RequiredClearance& required, double deviation) {
  const double need = required.level + deviation;
  const double at_least = map.clearance_bound(body.footprint, X_MB) - need;
  if (at_least >= kEnough) return at_least;
  const double in_hand = map.clearance(body.footprint, X_MB, need + kLookAhead) - need;
  if (in_hand >= 0.0 || (required.near.empty() && required.overlapped.empty())) return in_hand;
  return in_hand_near(X_MB, body, map, required, deviation);
}

}  // namespace

RequiredClearance required_clearance(double level, const Pose2& X_MB, double position_error,
                                     const BoundedFootprint& body, const StaticMap& map,
                                     const DriftBounds& drift) {
  RequiredClearance required{.level = level, .drift = drift};
  const double side = map.grid().resolution;
  std::vector<Eigen::Vector2d> close, overlapped;
  for (const auto& p_MC : map.squares_near(X_MB.position(), body.radius + level)) {
    const double gap = distance_to_square(body.footprint, X_MB, p_MC, side);
    if (gap >= level) continue;
    close.push_back(p_MC);
    if (gap <= kDifference) overlapped.push_back(p_MC);
    if (gap > kDifference) required.near.push_back(see(p_MC, side, X_MB, body.footprint));
  }
  required.possible =
      possible_poses(X_MB, position_error, drift.heading_error, body.footprint, close, side);
  if (overlapped.empty()) return required;
  required.inset = inset_until_clear(body.footprint, X_MB, overlapped, side);
  if (required.inset.parts.empty()) return required;
  for (const auto& p_MC : overlapped)
    required.overlapped.push_back(see(p_MC, side, X_MB, required.inset));
  return required;
}

bool stays_clear(std::span<const TwistRange> envelope, const ShareCell& cell, const Pose2& X_MB,
                 const BoundedFootprint& body, const StaticMap& map,
                 const RequiredClearance& required) {
  Pose2 X = X_MB;
  Deviation deviation{required.drift};
  double budget = 0.0;  // [m] travel that needs no check
  for (const auto& range : envelope) {
    const Twist2 twist = center_twist(range, cell), tolerance = half_width(range, cell);
    const double speed = std::abs(twist.v) + body.radius * std::abs(twist.w);
    for (double rest = range.dt; rest > 0.0;) {
      // Upper bound on the rate at which the clearance in hand is used up [m/s].
      const double rate = speed + deviation.rate(twist, tolerance, rest);
      const bool enough = rate * rest <= budget;
      const double step = enough ? rest : std::min(rest, std::max(budget, kCheckSpacing) / rate);
      X = integrate(X, twist, step);
      deviation.advance(twist, tolerance, step);
      rest -= step;
      budget -= rate * step;
      if (enough) break;
      budget = in_hand_at(X, body, map, required, deviation.outline());
      if (budget < 0.0) return false;
    }
  }
  return true;
}

}  // namespace tandem
