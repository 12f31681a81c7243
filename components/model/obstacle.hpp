// SPDX-License-Identifier: Apache-2.0
// The obstacle that planners and the safety filter use: an ellipse or a rectangle, moving or not.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "tandem/model/se2.hpp"

namespace tandem {

/// What an obstacle's `a` and `b` measure.
enum class ObstacleShape : std::uint8_t {
  kEllipse,    ///< the semi-axes; a circle if they are equal
  kRectangle,  ///< half the length and half the width
};

/// Ellipse or rectangle in the map frame M, moving with constant velocity.
struct Obstacle {
  std::uint32_t id = 0;                            ///< as its source numbers it
  Eigen::Vector2d p_MO = Eigen::Vector2d::Zero();  ///< centre [m]
  double a = 0.0;                                  ///< half extent along `angle` [m], a ≥ b > 0
  double b = 0.0;                                  ///< half extent across [m]
  double angle = 0.0;                              ///< heading of the axis a in M [rad]
  Eigen::Vector2d v_MO = Eigen::Vector2d::Zero();  ///< velocity [m/s]
  ObstacleShape shape = ObstacleShape::kEllipse;   ///< what `a` and `b` measure
  bool tracked = false;  ///< from /people: can move by itself, even if it stands now
};

/// Whether the obstacle moves noticeably.
[[nodiscard]] inline bool moves(const Obstacle& obstacle) {
  constexpr double kSlowest = 0.05;  // [m/s]
  return obstacle.v_MO.norm() > kSlowest;
}

/// Whether the obstacle is a rectangle.
[[nodiscard]] inline bool is_rectangle(const Obstacle& obstacle) {
  return obstacle.shape == ObstacleShape::kRectangle;
}
/// Whether the obstacle is an ellipse with equal semi-axes.
[[nodiscard]] inline bool is_circle(const Obstacle& obstacle) {
  return !is_rectangle(obstacle) && obstacle.a == obstacle.b;
}

/// Radius of the smallest circle about the centre that contains the obstacle [m].
[[nodiscard]] inline double circumradius(const Obstacle& obstacle) {
  return is_rectangle(obstacle) ? std::hypot(obstacle.a, obstacle.b) : obstacle.a;
}

/// An obstacle given in the fixed frame F, expressed in M.
[[nodiscard]] inline Obstacle transform(const Pose2& X_MF, Obstacle obstacle) {
  obstacle.p_MO = transform(X_MF, obstacle.p_MO);
  obstacle.v_MO = transform({0.0, 0.0, X_MF.theta}, obstacle.v_MO);
  obstacle.angle += X_MF.theta;
  return obstacle;
}

/// The point p_MQ in the axes of the obstacle [m].
[[nodiscard]] inline Eigen::Vector2d in_axes(const Obstacle& obstacle,
                                             const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d d = p_MQ - obstacle.p_MO;
  const double c = std::cos(obstacle.angle), s = std::sin(obstacle.angle);
  return {c * d.x() + s * d.y(), -s * d.x() + c * d.y()};
}

/// Whether the point is inside or on the outline.
[[nodiscard]] inline bool contains(const Obstacle& obstacle, const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d q = in_axes(obstacle, p_MQ);
  const double x = q.x() / obstacle.a, y = q.y() / obstacle.b;
  return is_rectangle(obstacle) ? std::abs(x) <= 1.0 && std::abs(y) <= 1.0 : x * x + y * y <= 1.0;
}

}  // namespace tandem
