// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/convex_hull.hpp"

#include <algorithm>
#include <cstddef>

namespace tandem {
namespace {

// Above 0 if b points to the left of a.
double left_turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& p, const auto& q) {
    return p.y() != q.y() ? p.y() < q.y() : p.x() < q.x();
  });
  // Andrew's monotone chain: the right side going up, then the left coming down.
  std::vector<Eigen::Vector2d> hull;
  const auto add = [&hull](const Eigen::Vector2d& p, std::size_t fixed) {
    while (hull.size() >= fixed + 2 &&
           left_turn(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 1e-12)
      hull.pop_back();
    hull.push_back(p);
  };
  for (const auto& p : points) add(p, 0);
  const std::size_t top = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, top);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

}  // namespace tandem
