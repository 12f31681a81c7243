// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/signed_distance.hpp"

#include <cmath>

#include "tandem/local_planner/ocp/distance_batch.hpp"

namespace tandem {

SignedDistance signed_distance_in_axes(const Obstacle& obstacle, const Eigen::Vector2d& axis,
                                       const Eigen::Vector2d& p_MQ) {
  using One = Lanes<1>;
  const double c = axis.x(), s = axis.y();
  const Eigen::Vector2d d_M = p_MQ - obstacle.p_MO;
  const Eigen::Vector2d p{c * d_M.x() + s * d_M.y(), c * d_M.y() - s * d_M.x()};
  const Eigen::Vector2d q = p.cwiseAbs().cwiseMax(kOffAxes * obstacle.b);
  const One a{obstacle.a}, b{obstacle.b}, q_x{q.x()}, q_y{q.y()};
  const auto d = is_rectangle(obstacle) ? distance_to_rectangle<1>(a, b, q_x, q_y)
                                        : distance_to_ellipse<1>(a, b, q_x, q_y);
  const Eigen::Vector2d n{std::copysign(d.n_x[0], p.x()), std::copysign(d.n_y[0], p.y())};
  return {d.value[0], {c * n.x() - s * n.y(), s * n.x() + c * n.y()}, d.curvature[0]};
}

}  // namespace tandem
