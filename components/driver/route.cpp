// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/route.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace tandem {

Route::Route(std::vector<Eigen::Vector2d> points) : points_{std::move(points)}, length_{0.0} {
  if (points_.size() < 2) throw std::invalid_argument("a route needs at least two points");
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const double step = (points_[i] - points_[i - 1]).norm();
    if (!(step > 1e-6)) throw std::invalid_argument("two consecutive points are the same");
    length_.push_back(length_.back() + step);
  }
}

std::size_t Route::segment_at(double s) const {
  const auto next = std::upper_bound(length_.begin() + 1, length_.end() - 1, s);
  return static_cast<std::size_t>(next - length_.begin()) - 1;
}

Eigen::Vector2d Route::point_at(double s) const {
  const std::size_t i = segment_at(s);
  const double share = (s - length_[i]) / (length_[i + 1] - length_[i]);
  return points_[i] + share * (points_[i + 1] - points_[i]);
}

double Route::heading_at(double s) const {
  const std::size_t i = segment_at(s);
  const Eigen::Vector2d along = points_[i + 1] - points_[i];
  return std::atan2(along.y(), along.x());
}

double Route::nearest(const Eigen::Vector2d& p_MQ, double from, double to) const {
  double best = std::clamp(from, 0.0, length());
  double best_distance = (point_at(best) - p_MQ).norm();
  for (std::size_t i = segment_at(best); i + 1 < points_.size() && length_[i] <= to; ++i) {
    const double step = length_[i + 1] - length_[i];
    const Eigen::Vector2d along = (points_[i + 1] - points_[i]) / step;
    const double low = std::max(best, length_[i]);
    const double high = std::max(low, std::min({to, length(), length_[i + 1]}));
    const double s = std::clamp(length_[i] + along.dot(p_MQ - points_[i]), low, high);
    const double distance = (point_at(s) - p_MQ).norm();
    if (distance >= best_distance) continue;
    best = s;
    best_distance = distance;
  }
  return best;
}

}  // namespace tandem
