// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/ellipse_distance.hpp"

#include <cmath>

#include "tandem/local_planner/ocp/ellipse_batch.hpp"

namespace tandem {

SignedDistance signed_distance_to_ellipse(const Obstacle& ellipse, const Eigen::Vector2d& axis,
                                          const Eigen::Vector2d& p_MQ) {
  using One = Lanes<1>;
  const double c = axis.x(), s = axis.y();
  const Eigen::Vector2d d_M = p_MQ - ellipse.p_MO;
  const Eigen::Vector2d p{c * d_M.x() + s * d_M.y(), c * d_M.y() - s * d_M.x()};
  const Eigen::Vector2d q = p.cwiseAbs().cwiseMax(kOffAxes * ellipse.b);
  const auto d = distance_to_outline<1>(One{ellipse.a}, One{ellipse.b}, One{q.x()}, One{q.y()});
  const Eigen::Vector2d n{std::copysign(d.n_x[0], p.x()), std::copysign(d.n_y[0], p.y())};
  return {d.value[0], {c * n.x() - s * n.y(), s * n.x() + c * n.y()}, d.curvature[0]};
}

}  // namespace tandem
