// SPDX-License-Identifier: Apache-2.0
// How far the robot can come away from a motion that was looked at.
#pragma once

#include <cmath>

#include "tandem/model/diff_drive.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// What makes the robot leave its motion, and the sizes that matter.
struct DriftBounds {
  double slip = 0.0;              ///< each wheel's travel is off by at most this fraction [1]
  double heading_error = 0.0;     ///< of the pose that the motion starts from [rad]
  double wheel_separation = 0.0;  ///< L [m]
  double radius = 0.0;            ///< R, circumradius of the outline [m]
};

/// Bound on how far any point of the outline is from where the motion puts it.
///
/// Wheel speeds v_l, v_r are off by at most the fraction ε, always the same way if need be, and v
/// and w themselves by at most Δv and Δw. Then heading and position are off by at most
///
///   dψ/dt = ε (|v_l| + |v_r|) / L + Δw               ψ(0) = heading_error                    (1)
///   dδ/dt = ε (|v_l| + |v_r|) / 2 + Δv + |v| ψ       δ(0) = 0                                (2)
///
/// with the largest wheel speeds that Δv and Δw allow, and a point of the outline by at most
///
///   d = δ + R (ψ − ψ(0)).                                                                    (3)
///
/// Straight on over the way s with slip opposite on the two wheels, ψ grows to 2 ε s / L and δ to
/// ε s² / L: (2) contains the sideways drift that a heading drift causes. R ψ(0) and the error of
/// the position that the motion starts from are parts of the margin, not of d.
class Deviation {
 public:
  explicit Deviation(const DriftBounds& bounds) : bounds_{bounds}, heading_{bounds.heading_error} {}

  /// After dt of `twist`, of which each component may be off by `tolerance` ≥ 0.
  void advance(const Twist2& twist, const Twist2& tolerance, double dt) {
    const double turning = heading_rate(twist, tolerance);
    position_ += dt * (position_rate(twist, tolerance) +
                       std::abs(twist.v) * (heading_ + 0.5 * turning * dt));
    heading_ += dt * turning;
  }
  /// (3) [m].
  [[nodiscard]] double outline() const {
    return position_ + bounds_.radius * (heading_ - bounds_.heading_error);
  }
  /// The fastest that (3) grows during the next dt [m/s].
  [[nodiscard]] double rate(const Twist2& twist, const Twist2& tolerance, double dt) const {
    const double turning = heading_rate(twist, tolerance);
    return position_rate(twist, tolerance) + std::abs(twist.v) * (heading_ + turning * dt) +
           bounds_.radius * turning;
  }

 private:
  [[nodiscard]] double rims(const Twist2& twist, const Twist2& tolerance) const {
    const WheelSpeeds wheels = to_wheels(twist, bounds_.wheel_separation);
    return std::abs(wheels.left) + std::abs(wheels.right) + 2.0 * tolerance.v +
           bounds_.wheel_separation * tolerance.w;
  }
  [[nodiscard]] double heading_rate(const Twist2& twist, const Twist2& tolerance) const {  // (1)
    return bounds_.slip * rims(twist, tolerance) / bounds_.wheel_separation + tolerance.w;
  }
  [[nodiscard]] double position_rate(const Twist2& twist, const Twist2& tolerance) const {  // (2)
    return 0.5 * bounds_.slip * rims(twist, tolerance) + tolerance.v;
  }

  DriftBounds bounds_;
  double position_ = 0.0;  // δ [m]
  double heading_;         // ψ [rad]
};

/// Bound on Deviation::outline() at the end of all motions with that reach [m].
[[nodiscard]] inline double largest_deviation(double path, double turn, const DriftBounds& bounds) {
  const double rims = 2.0 * path + bounds.wheel_separation * turn;
  const double turned = bounds.slip * rims / bounds.wheel_separation;
  return 0.5 * bounds.slip * rims + path * (bounds.heading_error + turned) + bounds.radius * turned;
}

}  // namespace tandem
