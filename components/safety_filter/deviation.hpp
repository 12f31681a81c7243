// SPDX-License-Identifier: Apache-2.0
// Bounds how far the robot can depart from a motion that was checked.
#pragma once

#include <cmath>

#include "tandem/model/diff_drive.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Causes of deviation and the dimensions that scale it.
struct DriftBounds {
  double slip = 0.0;              ///< each wheel's travel is off by at most this fraction [1]
  double heading_error = 0.0;     ///< bound on the heading error of the initial pose [rad]
  double wheel_separation = 0.0;  ///< L [m]
  double radius = 0.0;            ///< R, circumradius of the outline [m]
};

/// Bound on the distance of any point of the outline from its place in the checked motion.
///
/// Wheel speeds v_l, v_r are off by at most the fraction ε, in the worst case always in the same
/// direction, and v and w themselves by at most Δv and Δw. Then heading and position are off by at
/// most
///
///   dψ/dt = ε (|v_l| + |v_r|) / L + Δw               ψ(0) = heading_error                    (1)
///   dδ/dt = ε (|v_l| + |v_r|) / 2 + Δv + |v| ψ       δ(0) = 0                                (2)
///
/// with the largest wheel speeds that Δv and Δw allow, and a point of the outline by at most
///
///   d = δ + R (ψ − ψ(0)).                                                                    (3)
///
/// Driving straight over the distance s with opposite slip on the two wheels, ψ grows to 2 ε s / L
/// and δ to ε s² / L: (2) includes the sideways drift caused by a heading drift. R ψ(0) and the
/// error of the initial position are covered by the margin, not by d.
class Deviation {
 public:
  /// For odometry whose errors stay within the bounds.
  explicit Deviation(const DriftBounds& bounds) : bounds_{bounds}, heading_{bounds.heading_error} {}

  /// Advances by dt [s] of `twist`, each component of which may be off by `tolerance` ≥ 0.
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
  /// Upper bound on the growth of (3) during the next dt [m/s].
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

/// Upper bound on Deviation::outline() [m] at the end of any motion with this path [m] and turn
/// [rad], both absolute.
[[nodiscard]] inline double largest_deviation(double path, double turn, const DriftBounds& bounds) {
  const double rims = 2.0 * path + bounds.wheel_separation * turn;
  const double turned = bounds.slip * rims / bounds.wheel_separation;
  return 0.5 * bounds.slip * rims + path * (bounds.heading_error + turned) + bounds.radius * turned;
}

}  // namespace tandem
