// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/free_space.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/map/distance_transform.hpp"
#include "tandem/obstacle_extractor/cover/dilated_shape.hpp"

namespace tandem {
namespace {

using Mask = std::vector<std::uint8_t>;

constexpr double kFine = 0.027;    // [m] maximum spacing of the fine points
constexpr int kRows = 40;          // rows sampled of a long shape
constexpr double kPassage = 0.30;  // [m] a passage with less sideways room for the disc is narrow

// Distances to the mask's cells, in cells; larger than `most`, but no more, where they are.
std::vector<float> distance_up_to(double most, const Mask& mask, const CellRect& window) {
  return distance_transform(mask, window.width(), window.height(),
                            static_cast<int>(std::ceil(most)) + 1);
}

// Cells at least `radius` (in cells) away from all cells of the mask.
Mask far_from(const Mask& mask, const CellRect& window, double radius) {
  const auto gap = distance_up_to(radius, mask, window);
  Mask far(mask.size());
  for (std::size_t i = 0; i < gap.size(); ++i)
    far[i] = static_cast<double>(gap[i]) >= radius ? 1 : 0;
  return far;
}

// A cell's state depends on the places within the disc's diameter.
CellRect with_border(CellRect window, double radius) {
  const int border = static_cast<int>(std::ceil(2.0 * radius)) + 2;
  return {window.x0 - border, window.y0 - border, window.x1 + border, window.y1 + border};
}

// One coordinate of a fine point.
struct Between {
  int cell;   // that the point is in
  int lower;  // cell whose centre is the last one at or before the point
  double to;  // from there, in cells
};

std::vector<Between> points_between(int cells, int fine) {
  std::vector<Between> points;
  for (int i = 0; i < cells * fine; ++i) {
    const double at = (i + 0.5) / fine - 0.5;
    const int lower = static_cast<int>(std::floor(at));
    points.push_back({i / fine, lower, at - lower});
  }
  return points;
}

// The gaps of a window's cells and of those around it.
class Gaps {
 public:
  Gaps(const FreeRegions& places, const CellRect& window)
      : around_{-1, -1, window.width() + 1, window.height() + 1} {
    gaps_.reserve(around_.size());
    for (int iy = around_.y0; iy < around_.y1; ++iy)
      for (int ix = around_.x0; ix < around_.x1; ++ix)
        gaps_.push_back(places.gap(window.x0 + ix, window.y0 + iy));
  }

  // Whether the gap at a point is at least `least`, by linear interpolation between cell centres,
  // which is exact along a straight wall. At most points the four centres decide alone.
  [[nodiscard]] bool reach(const Between& x, const Between& y, double least) const {
    const float* row = &gaps_[around_.index(x.lower, y.lower)];
    const float* above = row + around_.width();
    const auto [min, max] = std::minmax({row[0], row[1], above[0], above[1]});
    if (static_cast<double>(min) > least + kRounding) return true;
    if (static_cast<double>(max) < least - kRounding) return false;
    const double u = x.to, v = y.to;
    return (1.0 - v) * ((1.0 - u) * static_cast<double>(row[0]) + u * static_cast<double>(row[1])) +
               v * ((1.0 - u) * static_cast<double>(above[0]) +
                    u * static_cast<double>(above[1])) >=
           least;
  }

 private:
  static constexpr double kRounding = 1e-6;  // [cells]

  CellRect around_;
  std::vector<float> gaps_;
};

}  // namespace

FreeSpace::FreeSpace(const StaticMap& map, const FreeRegions& places, const CellRect& window,
                     int region, double deepest)
    : resolution_{map.grid().resolution},
      radius_{places.radius()},
      window_{with_border(window, radius_)},
      first_center_{map.grid().center(window_.x0, window_.y0)},
      low_{map.grid().center(window.x0, window.y0)},
      high_{map.grid().center(window.x1 - 1, window.y1 - 1)},
      fine_{std::max(1, static_cast<int>(std::ceil(resolution_ / kFine - 1e-9)))},
      first_point_{first_center_.array() - 0.5 * resolution_ + 0.5 * resolution_ / fine_} {
  Mask all(window_.size()), own(window_.size());
  for (int iy = window_.y0; iy < window_.y1; ++iy)
    for (int ix = window_.x0; ix < window_.x1; ++ix) {
      const int at = places.region(ix, iy);
      all[window_.index(ix, iy)] = at != 0 ? 1 : 0;
      own[window_.index(ix, iy)] = at != 0 && (region == 0 || at == region) ? 1 : 0;
    }
  // Maximum reach of a disc. Along a straight wall the disc centres are this far from its foot.
  const double least = radius_ > 0.5 ? std::ceil(radius_ + 0.5) - 1.5 : 0.0;
  const Mask useless = far_from(all, window_, least + 1e-6);
  // The depth at a point is interpolated between cells, whose depths differ by at most √2.
  depth_ = distance_up_to(deepest / resolution_ + 2.0, useless, window_);
  for (float& depth : depth_) depth *= static_cast<float>(resolution_);
  find_useless();
  find_passages(own);
  sum_up(places, own);
}

// A passage is narrow where the region of places is at most 2 kPassage wide; narrow cells are those
// that the disc covers there.
void FreeSpace::find_passages(const Mask& places) {
  const double room = kPassage / resolution_;
  Mask other(places.size()), narrow(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) other[i] = places[i] == 0 ? 1 : 0;
  const auto to_wide = distance_up_to(room + 1.0, far_from(other, window_, room), window_);
  for (std::size_t i = 0; i < places.size(); ++i)
    narrow[i] = places[i] != 0 && static_cast<double>(to_wide[i]) > room + 1.0 ? 1 : 0;
  room_.assign(places.size(), Room::kOpen);
  if (std::find(narrow.begin(), narrow.end(), 1) == narrow.end()) return;
  const auto to_narrow = distance_up_to(radius_, narrow, window_);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (static_cast<double>(to_narrow[i]) <= radius_) room_[i] = Room::kNarrow;
}

bool FreeSpace::keep(const CellRect& window, const Mask& cells) {
  bool more = false;
  for (int iy = std::max(window.y0, window_.y0); iy < std::min(window.y1, window_.y1); ++iy)
    for (int ix = std::max(window.x0, window_.x0); ix < std::min(window.x1, window_.x1); ++ix) {
      Room& room = room_[window_.index(ix, iy)];
      if (cells[window.index(ix, iy)] == 0 || room != Room::kNarrow) continue;
      room = Room::kKept;
      more = true;
    }
  return more;
}

void FreeSpace::sum_up(const FreeRegions& places, const Mask& own) {
  Mask beside(own.size());  // a point between two cell centres can be a place through either cell
  for (int iy = window_.y0 + 1; iy < window_.y1 - 1; ++iy)
    for (int ix = window_.x0 + 1; ix < window_.x1 - 1; ++ix) {
      if (own[window_.index(ix, iy)] == 0) continue;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) beside[window_.index(ix + dx, iy + dy)] = 1;
    }
  const Gaps gaps(places, window_);
  const std::vector<Between> columns = points_between(window_.width(), fine_),
                             rows = points_between(window_.height(), fine_);
  sums_.resize((columns.size() + 1) * rows.size());
  float* sum = sums_.data();
  for (const Between& row : rows) {
    *sum++ = 0.0F;
    for (const Between& column : columns) {
      const bool is_place =
          beside[window_.index(window_.x0 + column.cell, window_.y0 + row.cell)] != 0 &&
          gaps.reach(column, row, radius_);
      *sum = sum[-1] + (is_place ? 1.0F : 0.0F);
      ++sum;
    }
  }
}

bool FreeSpace::is_known(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const {
  return (low.array() >= low_.array()).all() && (high.array() <= high_.array()).all();
}

double FreeSpace::taken_by(const Obstacle& shape, double most) const {
  return taken_by(shape, {std::cos(shape.angle), std::sin(shape.angle)}, most);
}

double FreeSpace::taken_by(const Obstacle& shape, const Eigen::Vector2d& along, double most) const {
  const double step = resolution_ / fine_, radius = radius_ * resolution_;
  const Eigen::Vector2d m = (shape.p_MO - first_point_) / step;
  return is_rectangle(shape) ? area_of(DilatedRectangle{shape, along, radius, step}, m, most)
                             : area_of(DilatedEllipse{shape, along, radius, step}, m, most);
}

double FreeSpace::taken_by(const std::vector<Eigen::Vector2d>& hull, double most) const {
  const double step = resolution_ / fine_;
  const DilatedHull all(hull, radius_ * resolution_, step);
  return area_of(all, (all.p_MC() - first_point_) / step, most);
}

// Sums row by row, from below: the outer rows, which are not through the obstacles, soonest show
// that the area is above `most`. `m`: the shape's centre, in fine points.
template <class Dilated>
double FreeSpace::area_of(const Dilated& shape, const Eigen::Vector2d& m, double most) const {
  const double step = resolution_ / fine_;
  const int width = window_.width() * fine_, height = window_.height() * fine_;
  const int low = std::max(0, static_cast<int>(std::ceil(m.y() - shape.reach())));
  const int high = std::min(height - 1, static_cast<int>(std::floor(m.y() + shape.reach())));
  const double all = width;
  const auto column = [all](double x) {  // points left of x: truncation is faster than ceil
    return static_cast<std::size_t>(std::clamp(x + 1.0, 0.0, all));
  };
  const int stride = 1 + (high - low) / kRows;
  const double per_point = step * step * stride;
  double sum = 0.0;
  for (int iy = low; iy <= high && sum * per_point <= most; iy += stride) {
    const RowExtent places = shape.row(iy - m.y());
    if (places.left > places.right) continue;
    const float* row = &sums_[static_cast<std::size_t>(iy) * static_cast<std::size_t>(width + 1)];
    sum +=
        static_cast<double>(row[column(m.x() + places.right)] - row[column(m.x() + places.left)]);
  }
  return sum * per_point;
}

bool FreeSpace::allows(const Eigen::Vector2d& p_MQ, const Excess& most) const {
  if (is_useless(p_MQ)) return true;
  const double at = depth(p_MQ);
  if (at <= std::min({most.open, most.narrow, most.kept}) || at > most.open) return at <= most.open;
  const Eigen::Vector2d c = (p_MQ - first_center_) / resolution_;
  const auto nearest = [](double x, int size) {
    return static_cast<int>(std::clamp(std::round(x), 0.0, size - 1.0));
  };
  const int ix = nearest(c.x(), window_.width()), iy = nearest(c.y(), window_.height());
  switch (room_[window_.index(window_.x0 + ix, window_.y0 + iy)]) {
    case Room::kOpen:
      return true;
    case Room::kNarrow:
      return at <= most.narrow;
    case Room::kKept:
      break;
  }
  return at <= std::min(most.narrow, most.kept);
}

// Fast path without interpolation: true for most points queried.
bool FreeSpace::is_useless(const Eigen::Vector2d& p_MQ) const {
  const Eigen::Vector2d c = (p_MQ - first_center_) / resolution_;
  if (!(c.x() >= 0.0 && c.y() >= 0.0 && c.x() < window_.width() && c.y() < window_.height()))
    return false;
  return useless_[window_.index(window_.x0 + static_cast<int>(c.x()),
                                window_.y0 + static_cast<int>(c.y()))] != 0;
}

// A square between four cell centres is useless if the depth is 0 at all four.
void FreeSpace::find_useless() {
  useless_.resize(window_.size());
  const auto at = [&](int ix, int iy) { return depth_[window_.index(ix, iy)] <= 0.0F; };
  for (int iy = window_.y0; iy + 1 < window_.y1; ++iy)
    for (int ix = window_.x0; ix + 1 < window_.x1; ++ix)
      useless_[window_.index(ix, iy)] =
          at(ix, iy) && at(ix + 1, iy) && at(ix, iy + 1) && at(ix + 1, iy + 1) ? 1 : 0;
}

double FreeSpace::depth(const Eigen::Vector2d& p_MQ) const {
  const Eigen::Vector2d c = (p_MQ - first_center_) / resolution_;
  const double x = std::clamp(c.x(), 0.0, window_.width() - 1.0);
  const double y = std::clamp(c.y(), 0.0, window_.height() - 1.0);
  const int ix = std::max(0, std::min(static_cast<int>(x), window_.width() - 2));
  const int iy = std::max(0, std::min(static_cast<int>(y), window_.height() - 2));
  const double u = x - ix, v = y - iy;
  const auto at = [&](int jx, int jy) {
    const int kx = std::min(jx, window_.width() - 1), ky = std::min(jy, window_.height() - 1);
    return static_cast<double>(depth_[static_cast<std::size_t>(ky * window_.width() + kx)]);
  };
  return (1.0 - v) * ((1.0 - u) * at(ix, iy) + u * at(ix + 1, iy)) +
         v * ((1.0 - u) * at(ix, iy + 1) + u * at(ix + 1, iy + 1));
}

}  // namespace tandem
