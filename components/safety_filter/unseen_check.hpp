// SPDX-License-Identifier: Apache-2.0
// Checks that a motion is slow wherever it reaches ground that no sensor has covered.
#pragma once

#include <array>
#include <span>

#include "tandem/map/static_map.hpp"
#include "tandem/safety_filter/clearance_check.hpp"
#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

/// Distance that fast motion must keep from an unseen cell on the side it moves to [m]. Map cells
/// are marked whole, so up to one diagonal of a 0.05 m cell at the outline's edge may never have
/// been seen.
inline constexpr double kUnseenEdge = 0.071;

/// Keeps the outline's fastest point no faster than `speed` over unseen ground.
///
/// The outline is extended by kUnseenEdge to the front if it drives forward, to the back if
/// backward, and to all sides if it turns. A motion is refused if this extended outline meets an
/// unseen cell before every point of it is, for the rest of the motion, no faster than `speed`. The
/// other sides do not count, so a robot can leave a place whose surroundings it has not seen.
/// Unseen obstacles are unknown anyway, so slip and heading error are not included. The fastest
/// point of a twist (v, w) is the vertex p of the outline with the largest
///
///   √((v − w p_y)² + (w p_x)²).                                                              (1)
class UnseenCheck {
 public:
  /// `speed` [m/s]; 0 forbids reaching unseen ground at all.
  UnseenCheck(double speed, const BoundedFootprint& body, double wheel_separation);

  /// (1) with the worst signs of v and w [m/s].
  [[nodiscard]] double fastest_point(const Twist2& twist) const;
  /// Whether (1) is at most `speed` for all twists up to this one, of both signs.
  [[nodiscard]] bool is_slow(const Twist2& twist) const;
  /// The largest fraction of a twist that is slow, at most 1.
  [[nodiscard]] double slow_share(const Twist2& twist) const;

  /// The leading part of the envelope, up to where all its motions stay slow. `measured`: twist at
  /// its start.
  [[nodiscard]] std::span<const TwistRange> fast_part(std::span<const TwistRange> envelope,
                                                      const Twist2& measured) const;

  /// The outline extended in the directions that this part of an envelope moves in. The reference
  /// is valid as long as this object.
  [[nodiscard]] const BoundedFootprint& drawn_out(std::span<const TwistRange> fast) const;

  /// Whether an extended outline meets no unseen cell on its way from X_MB, for all motions of the
  /// cell.
  [[nodiscard]] bool stays_off(std::span<const TwistRange> fast, const ShareCell& cell,
                               const Pose2& X_MB, const BoundedFootprint& body,
                               const StaticMap& unseen) const;

 private:
  static constexpr unsigned kForward = 1, kBackward = 2, kTurning = 4;

  double speed_;
  BoundedFootprint body_;
  DriftBounds drift_;
  std::array<BoundedFootprint, 8> drawn_out_;  // indexed by the sum of the flags above
};

}  // namespace tandem
