// SPDX-License-Identifier: Apache-2.0
// In: the static map and where the robot is. Out: the few circles and ellipses that cover every
// occupied cell near it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <unordered_map>
#include <vector>

#include "map/static_map.hpp"
#include "model/obstacle.hpp"
#include "obstacle_extractor/cover.hpp"
#include "params.hpp"

namespace tandem {

struct ExtractorParams {
  double range = 4.0;
  double max_excess = 0.06;
  double smallest_gap = 0.40;
  double tile = 4.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("range", range, Range{0.5, 50.0}, "[m] obstacles are fitted this near to the robot");
    field("max_excess", max_excess, Range{0.01, 1.0},
          "[m] how far a shape may reach into free space beyond its cells");
    field("smallest_gap", smallest_gap, Range{0.0, 2.0},
          "[m] gaps narrower than this may be filled; below the robot's width");
    field("tile", tile, Range{1.0, 20.0}, "[m] side of the squares that the map is fitted in");
  }
};

/// Covers the obstacle cells of a map by circles and ellipses, tile by tile as the robot comes
/// near, once each: a shape does not depend on where the robot is, and the cost of a call only on
/// the tiles it newly reaches.
class Extractor {
 public:
  /// Throws std::invalid_argument on parameters out of their ranges.
  Extractor(std::shared_ptr<const StaticMap> map, const ExtractorParams& params);

  /// Every obstacle cell whose square comes within `range` of the point lies wholly in one of the
  /// shapes. Order and ids are the same for the same map and parameters. Empty for a point that is
  /// not finite.
  [[nodiscard]] std::vector<Obstacle> near(const Eigen::Vector2d& p_MB);

 private:
  [[nodiscard]] const std::vector<CoverShape>& tile_at(int tx, int ty);

  std::shared_ptr<const StaticMap> map_;
  ExtractorParams params_;
  bool unknown_is_free_;  // there is no known free space: then the unknown must do
  std::unordered_map<std::int64_t, std::vector<CoverShape>> tiles_;
};

/// Extractor::near for one position, without memory.
[[nodiscard]] std::vector<Obstacle> extract(const StaticMap& map, const Eigen::Vector2d& p_MB,
                                            const ExtractorParams& params);

}  // namespace tandem
