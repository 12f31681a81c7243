// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/own_body.hpp"

#include <utility>

namespace tandem {

OwnBody::OwnBody(Footprint footprint)
    : footprint_{std::move(footprint)}, radius_{circumradius(footprint_)} {}

std::size_t OwnBody::drop(RangeReturns& echoes, const Eigen::Isometry3d& X_BS) const {
  return std::erase_if(echoes.p_SQ, [&](const Eigen::Vector3d& p_SQ) {
    const Eigen::Vector3d p_BQ = X_BS * p_SQ;
    return contains(p_BQ.head<2>());
  });
}

bool OwnBody::contains(const Eigen::Vector2d& p_BQ) const {
  return p_BQ.squaredNorm() <= radius_ * radius_ && distance(footprint_, p_BQ) <= 0.0;
}

}  // namespace tandem
