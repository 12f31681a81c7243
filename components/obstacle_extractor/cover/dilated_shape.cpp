// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/dilated_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tandem {

DilatedEllipse::DilatedEllipse(const Obstacle& shape, double radius, double step) {
  const double a = (shape.a + radius) / step, b = (shape.b + radius) / step;
  const double c = std::cos(shape.angle), s = std::sin(shape.angle);
  qxx_ = c * c / (a * a) + s * s / (b * b);
  qyy_ = s * s / (a * a) + c * c / (b * b);
  qxy_ = c * s * (1.0 / (a * a) - 1.0 / (b * b));
  per_ = 1.0 / qxx_;
  reach_ = std::hypot(s * a, c * b);
}

DilatedRectangle::DilatedRectangle(const Obstacle& shape, double radius, double step) {
  const double a = shape.a / step, b = shape.b / step, r = radius / step;
  const std::array<Eigen::Vector2d, 4> corners{{{a, b}, {-a, b}, {-a, -b}, {a, -b}}};
  const double c = std::cos(shape.angle), s = std::sin(shape.angle);
  reach_ = 0.0;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const std::size_t corner = i / 3;
    const double turn = 0.5 * std::numbers::pi * static_cast<double>(corner) +
                        0.25 * std::numbers::pi * static_cast<double>(i % 3);
    const Eigen::Vector2d p = corners[corner] + r * Eigen::Vector2d{std::cos(turn), std::sin(turn)};
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

std::variant<DilatedEllipse, DilatedRectangle> dilated(const Obstacle& shape, double radius,
                                                       double step) {
  if (is_rectangle(shape)) return DilatedRectangle{shape, radius, step};
  return DilatedEllipse{shape, radius, step};
}

}  // namespace tandem
