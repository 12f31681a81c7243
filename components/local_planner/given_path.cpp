// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/given_path.hpp"

namespace tandem {

void GivenPath::follow(std::span<const Eigen::Vector2d> path) {
  points_.clear();
  for (const Eigen::Vector2d& p : path) {
    while (!points_.empty() && (p - points_.back()).norm() > 1.5 * kSpacing)
      points_.push_back(points_.back() + kSpacing * (p - points_.back()).normalized());
    if (points_.empty() || (p - points_.back()).norm() > 1e-6) points_.push_back(p);
  }
}

void GivenPath::advance(const Eigen::Vector2d& p_MB) {
  const auto passed = static_cast<std::ptrdiff_t>(nearest_index(points_, p_MB, kSearchAhead));
  points_.erase(points_.begin(), points_.begin() + passed);
}

double GivenPath::length() const {
  double sum = 0.0;
  for (std::size_t i = 1; i < points_.size(); ++i) sum += (points_[i] - points_[i - 1]).norm();
  return sum;
}

std::size_t nearest_index(std::span<const Eigen::Vector2d> points, const Eigen::Vector2d& p,
                          double most) {
  std::size_t best = 0;
  double length = 0.0;
  for (std::size_t i = 1; i < points.size() && length < most; ++i) {
    length += (points[i] - points[i - 1]).norm();
    if ((points[i] - p).squaredNorm() < (points[best] - p).squaredNorm()) best = i;
  }
  return best;
}

}  // namespace tandem
