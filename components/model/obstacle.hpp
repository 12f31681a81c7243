// SPDX-License-Identifier: Apache-2.0
// The obstacle that planners and the safety filter use: an ellipse, moving or not.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "tandem/model/se2.hpp"

namespace tandem {

/// Ellipse in the map frame M, moving with constant velocity; a circle if a == b.
struct Obstacle {
  std::uint32_t id = 0;                            ///< as its source numbers it
  Eigen::Vector2d p_MO = Eigen::Vector2d::Zero();  ///< centre [m]
  double a = 0.0;                                  ///< semi-axis along `angle` [m], a ≥ b > 0
  double b = 0.0;                                  ///< semi-axis across [m]
  double angle = 0.0;                              ///< heading of the axis a in M [rad]
  Eigen::Vector2d v_MO = Eigen::Vector2d::Zero();  ///< velocity [m/s]
};

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

/// (x/a)² + (y/b)² of the point in the obstacle's axes: below 1 inside, above 1 outside.
[[nodiscard]] inline double level(const Obstacle& obstacle, const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d q = in_axes(obstacle, p_MQ);
  return (q.x() / obstacle.a) * (q.x() / obstacle.a) + (q.y() / obstacle.b) * (q.y() / obstacle.b);
}

}  // namespace tandem
