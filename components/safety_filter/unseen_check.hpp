// SPDX-License-Identifier: Apache-2.0
// Checks that a motion is slow where it reaches ground that no sensor has covered.
#pragma once

#include <array>
#include <span>

#include "tandem/map/static_map.hpp"
#include "tandem/safety_filter/clearance_check.hpp"
#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

/// The outline covers whole cells where it stands, so as much of a cell at its edge may never have
/// been seen: up to the diagonal of a cell of 0.05 m. What is fast must not come this near to an
/// unseen cell on the side it moves to [m].
inline constexpr double kUnseenEdge = 0.071;

/// Keeps the outline's fastest point from being faster than `speed` over unseen ground.
///
/// A motion is refused if the outline, drawn out by kUnseenEdge to the front if it drives forward,
/// to the back if backward, and to all sides if it turns, meets an unseen cell before
/// every point of it is, for the rest of the motion, no faster than `speed`. The other sides do not
/// count, so that a robot can leave a place that it has not seen around itself. What stands there
/// is unknown, so no drift is counted. The fastest point of a twist (v, w) is the vertex p of the
/// outline with the largest
///
///   √((v − w p_y)² + (w p_x)²).                                                              (1)
class UnseenCheck {
 public:
  /// `speed` in m/s; 0 forbids to reach unseen ground at all.
  UnseenCheck(double speed, const Body& body, double wheel_separation);

  /// (1) with the worst signs of v and w [m/s].
  [[nodiscard]] double fastest_point(const Twist2& twist) const;
  /// Whether (1) is at most `speed` for twists up to this one, both signs.
  [[nodiscard]] bool is_slow(const Twist2& twist) const;
  /// The largest part of a twist that is slow, at most 1.
  [[nodiscard]] double slow_share(const Twist2& twist) const;

  /// The envelope from its start, with the measured twist, until all its motions are slow for good.
  [[nodiscard]] std::span<const TwistRange> fast_part(std::span<const TwistRange> envelope,
                                                      const Twist2& measured) const;

  /// The outline drawn out to where a part of an envelope goes. Lives as long as this.
  [[nodiscard]] const Body& drawn_out(std::span<const TwistRange> fast) const;

  /// Whether an outline that is drawn out meets no unseen cell on its way from X_MB, in all motions
  /// of the cell.
  [[nodiscard]] bool stays_off(std::span<const TwistRange> fast, const ShareCell& cell,
                               const Pose2& X_MB, const Body& body, const StaticMap& unseen) const;

 private:
  static constexpr unsigned kForward = 1, kBackward = 2, kTurning = 4;

  double speed_;
  Body body_;
  DriftBounds drift_;
  std::array<Body, 8> drawn_out_;  // by the sum of the above
};

}  // namespace tandem
