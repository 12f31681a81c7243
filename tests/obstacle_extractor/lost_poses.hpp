// SPDX-License-Identifier: Apache-2.0
// Measures which robot poses near a drive are lost to the fitted shapes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/model/footprint.hpp"
#include "tandem/obstacle_extractor/extractor.hpp"

namespace tandem::test {

/// The poses that a robot can reach without contact, on a lattice of cells and headings.
class ReachablePoses {
 public:
  static constexpr int kHeadings = 16;

  /// All poses connected to those at `p_MS` (its nearest free cell) by steps of one cell or one
  /// heading, each free of contact by the exact outline and the exact cells. If the map has any
  /// unknown cells, they do not count as free.
  ReachablePoses(std::shared_ptr<const StaticMap> map, Footprint footprint,
                 const Eigen::Vector2d& p_MS);

  [[nodiscard]] Eigen::Vector2d start() const;

  /// Positions every `spacing` [m] along a shortest path from the start to the reachable pose
  /// nearest to `p_MZ`.
  [[nodiscard]] std::vector<Eigen::Vector2d> way_to(const Eigen::Vector2d& p_MZ,
                                                    double spacing) const;

  /// Position of a random reachable pose; deterministic for a given number.
  [[nodiscard]] Eigen::Vector2d some_place(unsigned number) const;

  /// Reachable poses per cell of the map's grid, and how many of them satisfy `is_lost`.
  struct Count {
    std::uint8_t reachable = 0, lost = 0;
  };
  template <class IsLost>
  [[nodiscard]] std::vector<Count> count(const IsLost& is_lost) const {
    std::vector<Count> counts(map_->grid().cells.size());
    for (std::size_t state = 0; state < steps_.size(); ++state) {
      if (steps_[state] < 0) continue;
      Count& cell = counts[state / kHeadings];
      ++cell.reachable;
      if (is_lost(pose(state))) ++cell.lost;
    }
    return counts;
  }

 private:
  [[nodiscard]] Pose2 pose(std::size_t state) const;
  [[nodiscard]] std::size_t nearest(const Eigen::Vector2d& p_MQ) const;
  template <class Visit>
  void for_neighbours(std::size_t state, const Visit& visit) const;

  std::shared_ptr<const StaticMap> map_;
  std::vector<std::int32_t> steps_;  // from the start, per cell and heading; -1: not reached
  std::vector<std::size_t> reached_;
};

/// Loss along drives. `poses` and `lost` count the poses within 3 m of each position of a drive.
struct Loss {
  double poses = 0.0, lost = 0.0, lost_to_discs = 0.0;
  std::vector<int> shapes;  ///< with a cell within 3 m, per position

  [[nodiscard]] double share() const { return lost / poses; }
  [[nodiscard]] double share_to_discs() const { return lost_to_discs / poses; }
  void add(const Loss& other);
  /// A fraction `share` of the positions has at most this many shapes.
  [[nodiscard]] int shapes_at(double share) const;
  [[nodiscard]] double mean_shapes() const;
};

constexpr double kNear = 3.0;  ///< [m]

/// Loss of one world along paths from `p_MS` to each of `goals`; if `disc_overhang` > 0, also the
/// loss by covering the outline with discs.
[[nodiscard]] Loss measure_loss(const std::shared_ptr<const StaticMap>& map,
                                const Footprint& footprint, const ReachablePoses& reachable,
                                const std::vector<Eigen::Vector2d>& goals,
                                const ExtractorParams& params, double disc_overhang);

}  // namespace tandem::test
