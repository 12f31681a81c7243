// SPDX-License-Identifier: Apache-2.0
// In: the static map and where the robot is. Out: the few circles and ellipses that cover every
// occupied cell near it.
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

struct ExtractorParams {
  double range = 4.0;
  double max_excess = 0.25;
  double smallest_gap = 0.42;
  double width = 0.58;  ///< [m] of the robot, whose ways stay open; its outline gives it
  double space_per_shape = 0.06;
  double tile = 4.0;
  int shapes_per_tile = 12;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("range", range, Range{0.5, 50.0}, "[m] obstacles are fitted this near to the robot");
    field("max_excess", max_excess, Range{0.01, 1.0},
          "[m] how far a shape may reach into free space; in narrow ways at most 0.05, unless it "
          "is crowded");
    field("smallest_gap", smallest_gap, Range{0.0, 2.0},
          "[m] gaps narrower than this may be filled; no more than the robot's width counts");
    field("space_per_shape", space_per_shape, Range{0.001, 10.0},
          "[m²] free space that one shape less may take; less: more and tighter shapes");
    field("tile", tile, Range{1.0, 20.0}, "[m] side of the squares that the map is fitted in");
    field("shapes_per_tile", shapes_per_tile, Range{1.0, 1000.0},
          "[-] a tile that needs more is crowded: its shapes get coarser until it does not, or "
          "space_per_shape is nine times as large; a way that was 0.15 m wider than the robot "
          "stays 0.09 m wider");
  }
};

/// Covers the obstacle cells of a map by circles and ellipses, tile by tile as the robot comes
/// near, once each: a shape does not depend on where the robot is, and the cost of a call only on
/// the tiles it newly reaches. What free space is worth does depend on the part of the map that the
/// robot can drive in; put down in another part, it gets shapes of their own for that.
///
/// When the map changes, a tile keeps its shapes as long as they cover its obstacle cells, but for
/// a few that get circles of their own; what has no cell left goes. Such shapes may not be the best
/// any more: refresh_near fits them again when there is time.
class Extractor {
 public:
  /// Throws std::invalid_argument on parameters out of their ranges.
  Extractor(std::shared_ptr<const StaticMap> map, const ExtractorParams& params);

  /// Goes on with a newer map. Tiles that the last one was not asked for are forgotten.
  void update(std::shared_ptr<const StaticMap> map);

  /// The robot is put down elsewhere: what follows is what a new extractor would say, sooner.
  void put_down() { region_ = 0; }

  /// Fits the tile near the point again that was fitted longest ago, of those whose cells or free
  /// space have changed since and that were fitted at least `settle` updates ago. False if there is
  /// none: with 0, then the shapes are those of a new extractor whose tiles lie the same.
  [[nodiscard]] bool refresh_near(const Eigen::Vector2d& p_MB, double range, long settle);

  /// Every obstacle cell whose square comes within `range` of the point lies wholly in one of the
  /// shapes. Order and ids are the same for the same map and parameters. Empty for a point that is
  /// not finite.
  [[nodiscard]] std::vector<Obstacle> near(const Eigen::Vector2d& p_MB);

  /// The same for any range [m], with the cells that each shape answers for.
  [[nodiscard]] std::vector<CoverShape> shapes_near(const Eigen::Vector2d& p_MB, double range);

 private:
  /// A square of the map, as it was when it was fitted.
  struct Tile {
    long map = 0;     // the update that it was last compared with
    long fitted = 0;  // the update that it was last fitted at
    int region = 0;   // that the robot was in when it was last compared
    std::vector<std::vector<CellIndex>> clusters;  // cells counted from the first map's origin
    std::uint64_t space = 0;                       // fingerprint of the places round it
    bool is_stale = false;                         // cells or places have changed since
    std::vector<CoverShape> shapes;
  };
  /// Tiles [x0, x1) × [y0, y1), numbered from the first map's origin.
  [[nodiscard]] CellRect tiles_near(const Eigen::Vector2d& p_MB, double range) const;
  [[nodiscard]] CellRect cells_of(int tx, int ty) const;
  [[nodiscard]] const Tile& tile_at(int tx, int ty);
  void fit(Tile& tile, int tx, int ty) const;
  [[nodiscard]] bool patch(Tile& tile) const;
  [[nodiscard]] std::uint32_t id_of(const CellIndex& lowest, const Eigen::Vector2d& p_MO) const;
  [[nodiscard]] std::uint64_t space_round(const CellRect& cells) const;
  void enter_region(const Eigen::Vector2d& p_MB);

  std::shared_ptr<const StaticMap> map_;
  ExtractorParams params_;
  FreeRegions places_;
  Eigen::Vector2i shift_{0, 0};  // from the first map's origin to this one's, in cells
  long updates_ = 1;
  int region_ = 0;  // where the robot was last; 0: none yet
  std::map<std::array<int, 2>, Tile> tiles_;
};

/// Extractor::near for one position, without memory.
[[nodiscard]] std::vector<Obstacle> extract(const StaticMap& map, const Eigen::Vector2d& p_MB,
                                            const ExtractorParams& params);

}  // namespace tandem
