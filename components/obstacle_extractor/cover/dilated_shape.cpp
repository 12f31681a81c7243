// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/dilated_shape.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

namespace tandem {
namespace {

bool is_lower(const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.y() < q.y(); }

}  // namespace

DilatedEllipse::DilatedEllipse(const Obstacle& shape, const Eigen::Vector2d& along, double radius,
                               double step) {
  const double a = (shape.a + radius) / step, b = (shape.b + radius) / step;
  const double c = along.x(), s = along.y();
  qxx_ = c * c / (a * a) + s * s / (b * b);
  qyy_ = s * s / (a * a) + c * c / (b * b);
  qxy_ = c * s * (1.0 / (a * a) - 1.0 / (b * b));
  per_ = 1.0 / qxx_;
  reach_ = std::sqrt(s * s * a * a + c * c * b * b);
}

DilatedRectangle::DilatedRectangle(const Obstacle& shape, const Eigen::Vector2d& along,
                                   double radius, double step) {
  const double a = shape.a / step, b = shape.b / step, r = radius / step;
  const std::array<Eigen::Vector2d, 4> corners{{{a, b}, {-a, b}, {-a, -b}, {a, -b}}};
  const double c = along.x(), s = along.y();
  constexpr double kDiagonal = 0.5 * std::numbers::sqrt2;
  const std::array<Eigen::Vector2d, 8> turns{{{1, 0},
                                              {kDiagonal, kDiagonal},
                                              {0, 1},
                                              {-kDiagonal, kDiagonal},
                                              {-1, 0},
                                              {-kDiagonal, -kDiagonal},
                                              {0, -1},
                                              {kDiagonal, -kDiagonal}}};
  reach_ = 0.0;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const std::size_t corner = i / 3;
    const Eigen::Vector2d p = corners[corner] + r * turns[(2 * corner + i % 3) % turns.size()];
    vertices_[i] = {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
    reach_ = std::max(reach_, vertices_[i].y());
  }
}

RowExtent DilatedRectangle::row(double y) const {
  RowExtent row{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  const auto include = [&row](double x) {
    row.left = std::min(row.left, x);
    row.right = std::max(row.right, x);
  };
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Eigen::Vector2d &p = vertices_[i], &q = vertices_[i + 1 < vertices_.size() ? i + 1 : 0];
    if (p.y() == y) include(p.x());
    if ((p.y() < y) != (q.y() < y) && p.y() != q.y())
      include(p.x() + (y - p.y()) / (q.y() - p.y()) * (q.x() - p.x()));
  }
  return row;
}

DilatedHull::DilatedHull(const Points& hull, double radius, double step) {
  const auto [low, high] = std::minmax_element(hull.begin(), hull.end(), is_lower);
  p_MC_ = {hull[0].x(), 0.5 * (low->y() + high->y())};
  reach_ = (0.5 * (high->y() - low->y()) + radius) / step;
  const std::size_t corners = hull.size();
  const auto normal = [&](std::size_t i) {  // of the edge from corner i on, outwards
    const Eigen::Vector2d edge = hull[i + 1 < corners ? i + 1 : 0] - hull[i];
    return Eigen::Vector2d{Eigen::Vector2d{edge.y(), -edge.x()}.normalized()};
  };
  Points outline;
  outline.reserve(3 * corners);
  Eigen::Vector2d before = normal(corners - 1);
  for (std::size_t i = 0; i < corners; ++i) {
    const Eigen::Vector2d p = (hull[i] - p_MC_) / step, after = normal(i);
    for (const Eigen::Vector2d& to :
         {before, Eigen::Vector2d{(before + after).normalized()}, after})
      outline.push_back(p + radius / step * to);
    before = after;
  }
  std::rotate(outline.begin(), std::min_element(outline.begin(), outline.end(), is_lower),
              outline.end());
  const auto top = std::max_element(outline.begin(), outline.end(), is_lower);
  Points left;
  left.reserve(outline.size());
  left.push_back(outline.front());
  left.insert(left.end(), outline.rbegin(), std::make_reverse_iterator(top));
  left_ = Side{std::move(left)};
  outline.erase(top + 1, outline.end());
  right_ = Side{std::move(outline)};
}

double DilatedHull::Side::x_at(double y) const {
  while (above_ > 1 && line_[above_ - 1].y() >= y) --above_;
  while (above_ + 1 < line_.size() && line_[above_].y() < y) ++above_;
  const Eigen::Vector2d &p = line_[above_ - 1], &q = line_[above_];
  return q.y() > p.y() ? p.x() + (y - p.y()) / (q.y() - p.y()) * (q.x() - p.x()) : q.x();
}

}  // namespace tandem
