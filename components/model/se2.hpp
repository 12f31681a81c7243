// SPDX-License-Identifier: Apache-2.0
// Poses and twists in the plane, their composition, and exact motion along an arc. Frames: M = map,
// W = odom, B = base_link. REP-103: metres, radians, x forward, y left, CCW +.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace tandem {

/// Pose X_AB of frame B in frame A: position [m, m] and heading [rad].
struct Pose2 {
  double x = 0.0, y = 0.0, theta = 0.0;  ///< [m], [m], [rad], counter-clockwise

  /// The origin of B in A, p_AB [m].
  [[nodiscard]] Eigen::Vector2d position() const { return {x, y}; }
  bool operator==(const Pose2&) const = default;
};

/// Body twist of a differential drive: forward speed [m/s] and yaw rate [rad/s].
struct Twist2 {
  double v = 0.0, w = 0.0;  ///< [m/s], forward; [rad/s], counter-clockwise

  bool operator==(const Twist2&) const = default;
};

/// Whether no number of the pose is NaN or infinite.
[[nodiscard]] inline bool is_finite(const Pose2& X) {
  return std::isfinite(X.x) && std::isfinite(X.y) && std::isfinite(X.theta);
}
/// Whether no number of the twist is NaN or infinite.
[[nodiscard]] inline bool is_finite(const Twist2& twist) {
  return std::isfinite(twist.v) && std::isfinite(twist.w);
}

/// The equivalent angle in (−π, π].
[[nodiscard]] inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? wrapped + 2.0 * std::numbers::pi : wrapped;
}

/// p_AQ = X_AB p_BQ.
[[nodiscard]] inline Eigen::Vector2d transform(const Pose2& X_AB, const Eigen::Vector2d& p_BQ) {
  const double c = std::cos(X_AB.theta), s = std::sin(X_AB.theta);
  return {X_AB.x + c * p_BQ.x() - s * p_BQ.y(), X_AB.y + s * p_BQ.x() + c * p_BQ.y()};
}

/// X_AC = X_AB X_BC.
[[nodiscard]] inline Pose2 compose(const Pose2& X_AB, const Pose2& X_BC) {
  const Eigen::Vector2d p = transform(X_AB, {X_BC.x, X_BC.y});
  return {p.x(), p.y(), wrap_angle(X_AB.theta + X_BC.theta)};
}

/// X_BA, so that compose(X_AB, inverse(X_AB)) is the identity.
[[nodiscard]] inline Pose2 inverse(const Pose2& X_AB) {
  const double c = std::cos(X_AB.theta), s = std::sin(X_AB.theta);
  return {-c * X_AB.x - s * X_AB.y, s * X_AB.x - c * X_AB.y, wrap_angle(-X_AB.theta)};
}

/// Pose after `dt` seconds of constant `twist`: the exact unicycle arc,
///
///   x⁺ = x + v dt sinc(w dt / 2) cos(θ + w dt / 2)
///   y⁺ = y + v dt sinc(w dt / 2) sin(θ + w dt / 2)                      (1)
///   θ⁺ = θ + w dt          (not wrapped, so that a path of headings stays continuous)
[[nodiscard]] inline Pose2 integrate(const Pose2& X, const Twist2& twist, double dt) {
  const double half = 0.5 * twist.w * dt;
  const double sinc = std::abs(half) < 1e-4 ? 1.0 - half * half / 6.0 : std::sin(half) / half;
  const double chord = twist.v * dt * sinc;
  return {X.x + chord * std::cos(X.theta + half), X.y + chord * std::sin(X.theta + half),
          X.theta + twist.w * dt};
}

}  // namespace tandem
