// SPDX-License-Identifier: Apache-2.0
// Covers the occupied cells near the robot by a few rectangles, circles and ellipses, which the
// planner can handle as obstacles.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/cover.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

/// Range and tightness of the fitted shapes.
struct ExtractorParams {
  double range = 4.0;
  double max_excess = 0.25;
  double smallest_gap = 0.42;
  double width = 0.58;  ///< [m] of the robot, from its outline; passages this wide stay open
  double space_per_shape = 0.03;
  double tile = 4.0;
  int shapes_per_tile = 12;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("range", range, Range{0.5, 50.0},
          "[m] obstacles are fitted within this distance of the robot");
    field("max_excess", max_excess, Range{0.01, 1.0},
          "[m] how far a shape may extend into free space; in narrow passages at most 0.05, except "
          "in crowded tiles");
    field("smallest_gap", smallest_gap, Range{0.0, 2.0},
          "[m] gaps narrower than this may be filled; capped at the robot's width");
    field("space_per_shape", space_per_shape, Range{0.001, 10.0},
          "[m²] free space that may be given up to save one shape; smaller values give more and "
          "tighter shapes");
    field("tile", tile, Range{1.0, 20.0},
          "[m] side of the square tiles in which the map is fitted");
    field("shapes_per_tile", shapes_per_tile, Range{1.0, 1000.0},
          "[-] shapes per tile above which a tile is crowded: its shapes are coarsened until it is "
          "not, or until space_per_shape is nine times as large; a passage 0.15 m wider than the "
          "robot stays at least 0.09 m wider");
  }
};

/// Covers the obstacle cells of a map by simple shapes. The map is fitted tile by tile as
/// the robot approaches, each tile once: shapes do not depend on the robot's position, and a call
/// costs time only for tiles that it newly reaches. Shapes do depend on the free region that the
/// robot can drive in, so tiles are refitted when the robot is relocalized into another region.
///
/// When the map changes, a tile keeps its shapes as long as they cover its obstacle cells; a few
/// new cells get rectangles of their own, and shapes without cells are removed. The kept shapes may
/// no longer be the best; refresh_near refits them when there is time.
class Extractor {
 public:
  /// Throws std::invalid_argument on parameters out of their ranges.
  Extractor(std::shared_ptr<const StaticMap> map, const ExtractorParams& params);

  /// Switches to a newer map. Tiles that were not requested since the previous update are dropped.
  void update(std::shared_ptr<const StaticMap> map);

  /// Call after the robot was relocalized: its free region is determined again. The shapes are then
  /// those of a new extractor, but tiles that are still valid are reused.
  void put_down() { region_ = 0; }

  /// Refits one tile near the point: of those whose cells or free space have changed and that were
  /// fitted at least `settle` updates ago (twice as many 1 m from the point, thrice as many 2 m
  /// from it), the one fitted longest ago. Returns false if there is none. Once it returns false
  /// for settle = 0, the shapes equal those of a new extractor with the same tile boundaries.
  [[nodiscard]] bool refresh_near(const Eigen::Vector2d& p_MB, double range, long settle);

  /// Shapes that together contain every obstacle cell whose square comes within `range` of the
  /// point; each such cell lies wholly in one shape. Order and ids are the same for the same map
  /// and parameters. Empty for a point that is not finite.
  [[nodiscard]] std::vector<Obstacle> near(const Eigen::Vector2d& p_MB);

  /// Like `near` for any range [m], with the bounding box of the cells that each shape covers.
  [[nodiscard]] std::vector<CoverShape> shapes_near(const Eigen::Vector2d& p_MB, double range);

 private:
  /// A square of the map in the state of its last fit.
  struct Tile {
    long map = 0;     // update at which it was last compared with the map
    long fitted = 0;  // update at which it was last fitted
    int region = 0;   // the robot's region at the last comparison
    std::vector<std::vector<CellIndex>> clusters;  // cell indices from the first map's origin
    std::uint64_t space = 0;                       // hash of the free regions around it
    bool is_stale = false;                         // cells or free regions changed since the fit
    std::vector<CoverShape> shapes;
  };
  /// Tiles [x0, x1) × [y0, y1), numbered from the first map's origin.
  [[nodiscard]] CellRect tiles_near(const Eigen::Vector2d& p_MB, double range) const;
  [[nodiscard]] CellRect cells_of(int tx, int ty) const;
  [[nodiscard]] double distance_to_tile(const std::array<int, 2>& place,
                                        const Eigen::Vector2d& p_MB) const;
  [[nodiscard]] const Tile& tile_at(int tx, int ty);
  void fit(Tile& tile, int tx, int ty) const;
  [[nodiscard]] bool patch(Tile& tile) const;
  [[nodiscard]] CoverShape shape_of(const CellRect& cells) const;
  [[nodiscard]] std::uint32_t id_of(const CellIndex& lowest, const Eigen::Vector2d& p_MO) const;
  [[nodiscard]] std::uint64_t space_round(const CellRect& cells) const;
  void enter_region(const Eigen::Vector2d& p_MB);

  std::shared_ptr<const StaticMap> map_;
  ExtractorParams params_;
  FreeRegions places_;
  Eigen::Vector2i shift_{0, 0};  // from the first map's origin to this one's, in cells
  long updates_ = 1;
  int region_ = 0;  // the robot's last region; 0: none yet
  std::map<std::array<int, 2>, Tile> tiles_;
};

/// Extractor::near for one position, without state.
[[nodiscard]] std::vector<Obstacle> extract(const StaticMap& map, const Eigen::Vector2d& p_MB,
                                            const ExtractorParams& params);

}  // namespace tandem
