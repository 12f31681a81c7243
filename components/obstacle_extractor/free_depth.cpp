// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/free_depth.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "map/distance_transform.hpp"

namespace tandem {
namespace {

using Mask = std::vector<std::uint8_t>;

Mask useless_cells(const StaticMap& map, const CellRect& window, bool unknown_is_free) {
  Mask mask;
  mask.reserve(static_cast<std::size_t>(window.width()) *
               static_cast<std::size_t>(window.height()));
  for (int iy = window.y0; iy < window.y1; ++iy)
    for (int ix = window.x0; ix < window.x1; ++ix) {
      const bool known_free = map.grid().contains(ix, iy) && map.grid().at(ix, iy) == Cell::kFree;
      mask.push_back(map.is_obstacle(ix, iy) || !(known_free || unknown_is_free) ? 1 : 0);
    }
  return mask;
}

// Cells that no free disc of `radius` (in cells) reaches: the opening of the free space.
Mask close_gaps(const Mask& useless, const CellRect& window, double radius) {
  const auto gap = distance_transform(useless, window.width(), window.height());
  Mask middle(useless.size());
  for (std::size_t i = 0; i < gap.size(); ++i) middle[i] = gap[i] >= radius ? 1 : 0;
  const auto reach = distance_transform(middle, window.width(), window.height());
  // As far as the middles of discs along a straight wall are from the cells at its foot.
  const double least = std::ceil(radius + 0.5) - 1.5;
  Mask closed(useless.size());
  for (std::size_t i = 0; i < reach.size(); ++i) closed[i] = reach[i] > least + 1e-6 ? 1 : 0;
  return closed;
}

// Whether a gap is closed is decided by the cells within its width.
CellRect with_border(CellRect window, double gap, double resolution) {
  const int border = static_cast<int>(std::ceil(gap / resolution)) + 2;
  return {window.x0 - border, window.y0 - border, window.x1 + border, window.y1 + border};
}

}  // namespace

FreeDepth::FreeDepth(const StaticMap& map, const CellRect& window, const FreeDepthParams& params)
    : resolution_{map.grid().resolution},
      window_{with_border(window, params.smallest_gap, resolution_)},
      first_center_{map.grid().center(window_.x0, window_.y0)},
      low_{map.grid().center(window.x0, window.y0)},
      high_{map.grid().center(window.x1 - 1, window.y1 - 1)} {
  Mask useless = useless_cells(map, window_, params.unknown_is_free);
  const double radius = 0.5 * params.smallest_gap / resolution_;
  if (radius > 0.5) useless = close_gaps(useless, window_, radius);
  const double most = window_.width() + window_.height();  // in place of infinity
  for (const double depth : distance_transform(useless, window_.width(), window_.height()))
    depth_.push_back(static_cast<float>(resolution_ * std::min(depth, most)));
}

bool FreeDepth::knows(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const {
  return (low.array() >= low_.array()).all() && (high.array() <= high_.array()).all();
}

double FreeDepth::at(const Eigen::Vector2d& p_MQ) const {
  const Eigen::Vector2d c = (p_MQ - first_center_) / resolution_;
  const double x = std::clamp(c.x(), 0.0, window_.width() - 1.0);
  const double y = std::clamp(c.y(), 0.0, window_.height() - 1.0);
  const int ix = std::max(0, std::min(static_cast<int>(x), window_.width() - 2));
  const int iy = std::max(0, std::min(static_cast<int>(y), window_.height() - 2));
  const double u = x - ix, v = y - iy;
  const auto depth = [&](int jx, int jy) {
    const int kx = std::min(jx, window_.width() - 1), ky = std::min(jy, window_.height() - 1);
    return static_cast<double>(depth_[static_cast<std::size_t>(ky * window_.width() + kx)]);
  };
  return (1.0 - v) * ((1.0 - u) * depth(ix, iy) + u * depth(ix + 1, iy)) +
         v * ((1.0 - u) * depth(ix, iy + 1) + u * depth(ix + 1, iy + 1));
}

}  // namespace tandem
