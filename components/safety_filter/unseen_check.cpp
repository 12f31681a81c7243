// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/unseen_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {
namespace {

constexpr double kSpeedRounding = 1e-6;  // [m/s]
constexpr double kSwing = 0.01;          // [m/s] speed from which swinging corners count as turning

Twist2 largest(const TwistRange& range) {
  return {std::max(std::abs(range.low.v), std::abs(range.high.v)),
          std::max(std::abs(range.low.w), std::abs(range.high.w))};
}

// Adds a copy of the outline, moved by `way`.
void add_moved(Footprint& footprint, const Footprint& outline, const Eigen::Vector2d& way) {
  for (ConvexPolygon part : outline.parts) {
    for (Eigen::Vector2d& p_BV : part) p_BV += way;
    footprint.parts.push_back(std::move(part));
  }
}

}  // namespace

UnseenCheck::UnseenCheck(double speed, const BoundedFootprint& body, double wheel_separation)
    : speed_{speed},
      body_{body},
      drift_{.wheel_separation = wheel_separation, .radius = body.radius + kUnseenEdge} {
  for (unsigned sides = 0; sides < drawn_out_.size(); ++sides) {
    Footprint& footprint = drawn_out_[sides].footprint = body.footprint;
    const auto draw_out = [&](unsigned to, double x, double y) {
      if ((sides & to) != 0) add_moved(footprint, body.footprint, {x, y});
    };
    draw_out(kForward, kUnseenEdge, 0.0);
    draw_out(kBackward, -kUnseenEdge, 0.0);
    draw_out(kTurning, 0.0, kUnseenEdge);
    draw_out(kTurning, 0.0, -kUnseenEdge);
    drawn_out_[sides].radius = body.radius + kUnseenEdge;
  }
}

double UnseenCheck::fastest_point(const Twist2& twist) const {
  double fastest = std::abs(twist.v);
  for (const ConvexPolygon& part : body_.footprint.parts)
    for (const Eigen::Vector2d& p_BV : part)
      fastest = std::max(fastest, std::hypot(std::abs(twist.v) + std::abs(twist.w * p_BV.y()),
                                             twist.w * p_BV.x()));
  return fastest;
}

bool UnseenCheck::is_slow(const Twist2& twist) const {
  return fastest_point(twist) <= speed_ + kSpeedRounding;
}

double UnseenCheck::slow_share(const Twist2& twist) const {
  const double fastest = fastest_point(twist);
  return fastest <= speed_ ? 1.0 : speed_ / fastest;
}

// The ends of a range are means over its duration; the speed at its start is at most that of the
// range before it.
std::span<const TwistRange> UnseenCheck::fast_part(std::span<const TwistRange> envelope,
                                                   const Twist2& measured) const {
  std::size_t end = envelope.size();
  const auto begins_slowly = [&](std::size_t i) {
    return is_slow(i == 0 ? measured : largest(envelope[i - 1]));
  };
  while (end > 0 && is_slow(largest(envelope[end - 1])) && begins_slowly(end - 1)) --end;
  return envelope.first(end);
}

const BoundedFootprint& UnseenCheck::drawn_out(std::span<const TwistRange> fast) const {
  unsigned sides = 0;
  for (const TwistRange& range : fast) {
    const Twist2 most = largest(range);
    if (range.high.v > kSpeedRounding) sides |= kForward;
    if (range.low.v < -kSpeedRounding) sides |= kBackward;
    if (fastest_point({0.0, most.w}) > kSwing) sides |= kForward | kBackward | kTurning;
  }
  return drawn_out_[sides];
}

bool UnseenCheck::stays_off(std::span<const TwistRange> fast, const ShareCell& cell,
                            const Pose2& X_MB, const BoundedFootprint& body,
                            const StaticMap& unseen) const {
  const double gap = unseen.clearance(body.footprint, X_MB, kCheckSpacing);
  if (gap <= 0.0) return false;
  // Between two checked poses the gap shrinks by at most half of their spacing.
  const double level = std::min(0.5 * kCheckSpacing, 0.5 * gap);
  return stays_clear(fast, cell, X_MB, body, unseen, {.level = level, .drift = drift_});
}

}  // namespace tandem
