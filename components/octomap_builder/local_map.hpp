// SPDX-License-Identifier: Apache-2.0
// Keeps an OctoMap of the robot's surroundings, built from range measurements.
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "tandem/config/params.hpp"
#include "tandem/map/range_returns.hpp"
#include "tandem/model/footprint.hpp"
#include "tandem/octomap_builder/voxel_times.hpp"

namespace tandem {

/// Parameter names follow ROS 2's octomap_server where it has an equivalent.
struct LocalMapParams {
  double resolution = 0.05;
  double window = 20.0;
  double min_range = 0.1;
  double max_range = 8.0;
  double point_cloud_min_z = -0.5;
  double point_cloud_max_z = 1.5;
  double decay = 0.0;
  double coverage_timeout = 30.0;
  double hit = 0.9;
  double miss = 0.4;
  double clamp_min = 0.12;
  double clamp_max = 0.97;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("resolution", resolution, Range{0.01, 0.5}, "[m] edge length of a voxel");
    field("window", window, Range{2.0, 100.0},
          "[m] side of the square around the robot that is kept in the map");
    field("min_range", min_range, Range{0.0, 5.0}, "[m] returns nearer to the sensor are ignored");
    field("max_range", max_range, Range{0.5, 100.0},
          "[m] returns farther away mark no obstacle; they only clear space along the beam");
    field("point_cloud_min_z", point_cloud_min_z, Range{-10.0, 100.0},
          "[m] height in the map; lower returns mark no obstacle; they only clear space along the "
          "beam");
    field("point_cloud_max_z", point_cloud_max_z, Range{-10.0, 100.0},
          "[m] height in the map; higher returns mark no obstacle; they only clear space along the "
          "beam");
    field("decay", decay, Range{0.0, 3600.0},
          "[s] an obstacle that no beam has measured for this long becomes unseen ground; 0: it "
          "stays until a beam shows it is gone");
    field("coverage_timeout", coverage_timeout, Range{0.5, 3600.0},
          "[s] free ground that no beam has covered for this long becomes unseen ground");
    field("hit", hit, Range{0.5, 0.999}, "[1] probability that a voxel with a return is occupied");
    field("miss", miss, Range{0.001, 0.5},
          "[1] probability that a voxel a beam passed through is occupied");
    field("clamp_min", clamp_min, Range{0.001, 0.499},
          "[1] lower limit of a voxel's occupancy probability");
    field("clamp_max", clamp_max, Range{0.501, 0.999},
          "[1] upper limit of a voxel's occupancy probability");
  }
};

/// Range returns of a sensor at X_MS.
struct Look {
  RangeReturns echoes;     ///< in S
  Eigen::Isometry3d X_MS;  ///< of the sensor
};

/// An OctoMap of a window around the robot, updated with range returns.
///
/// One return makes a voxel an obstacle, whatever its state was. A voxel in known free space that
/// was hit only once is cleared by the next beam that passes through it; an obstacle that was seen
/// for long needs several. Voxels that were not covered for coverage_timeout, or never, are unknown
/// in the tree. They are removed up to a second early, so that a moving robot can slow down in
/// time. A beam covers the voxels from the sensor to its return: what lies behind the return stays
/// unknown, and the space within the sensor's minimum range is covered by every beam that reaches
/// beyond it. The window bounds the memory.
class LocalMap {
 public:
  /// Throws std::invalid_argument on parameters out of range, if the lower height limit is not
  /// below the upper one, and if one return would not make a free voxel an obstacle.
  explicit LocalMap(const LocalMapParams& params);
  LocalMap(const LocalMap&) = delete;
  LocalMap& operator=(const LocalMap&) = delete;

  /// Inserts looks at time t [s] as one measurement: a voxel hit in one of them is not cleared by
  /// another. At most 30,000 different rays of each look clear space. The window follows the
  /// sensor. Returns false and inserts nothing if an X_MS is not finite or beyond OctoMap's reach
  /// (2¹⁵ voxels from the map's origin).
  [[nodiscard]] bool insert(std::span<const Look> looks, double t);

  /// Marks the ground under the robot as free: its outline is at X_MB at time t [s], and nothing
  /// else stands there or on the way from its pose at the last call. Covers the ground at height z
  /// [m]; obstacles stay obstacles. An outline that is not finite or outside the window covers
  /// nothing.
  void stand(const Footprint& outline, const Pose2& X_MB, double z, double t);

  /// Removes all voxels.
  void clear();

  /// Only the leaves are up to date: inner nodes are neither updated nor pruned.
  [[nodiscard]] const octomap::OcTree& tree() const { return tree_; }

 private:
  // Voxels [low, high] of the window, as OctoMap keys.
  struct Box {
    octomap::OcTreeKey low, high;
    [[nodiscard]] bool contains(const octomap::OcTreeKey& key) const;
  };

  [[nodiscard]] double farthest() const;
  void look(const Look& look);
  void set_free(const octomap::OcTreeKey& key, double t);
  void follow(const Eigen::Vector3d& p_MS);
  [[nodiscard]] Box box_around(const Eigen::Vector3d& p_MC) const;
  void clear_way(const Eigen::Vector3d& p_MS, const Eigen::Vector3d& p_MQ);
  void cover(const Footprint& outline, const Pose2& X_MB, double z, double t);
  void forget_old(double t);

  LocalMapParams params_;
  octomap::OcTree tree_;
  Box window_;
  Eigen::Vector3d p_MC_;  // the window's centre
  VoxelTimes covered_;
  double swept_out_ = 0.0;  // [s] last search for old voxels

  struct Stand {
    Pose2 X_MB;
    double t;
  };
  std::optional<Stand> stood_;  // where the outline last covered ground

  // Scratch buffers for the looks being inserted; members to keep their memory.
  octomap::KeyRay ray_;
  octomap::KeySet free_, occupied_, ends_;
};

}  // namespace tandem
