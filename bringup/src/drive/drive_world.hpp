// SPDX-License-Identifier: Apache-2.0
// Builds the world of a drive from its parameters: the true map, what the robot knows of it, and
// its simulated sensing.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bringup/scenario/scenario.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/io/map_input.hpp"
#include "tandem/obstacle_extractor/extractor.hpp"
#include "tandem/octomap_builder/octomap_builder_node.hpp"

namespace tandem {

/// Whether the robot uses a map built from its own scans, alone or with the static map.
[[nodiscard]] inline bool is_seen_live(const MapInputParams& params) {
  return params.map_source != "static";
}

/// The static part of the map of a robot with live sensing: the loaded map unless the source is
/// "local", and the forbidden zones.
[[nodiscard]] Grid base_of(const DiffDriveSimNodeParams& sim, const MapInputParams& params);

/// The ground that is known from the static map, for unseen_ground_over; empty unless the map
/// source is "both".
[[nodiscard]] Grid known_ground_of(const DiffDriveSimNodeParams& sim, const MapInputParams& params);

/// A scan of the simulated scanner.
struct SimulatedScan {
  RangeScan form;  ///< without its ranges
  std::vector<float> ranges;

  [[nodiscard]] RangeScan scan() const {
    RangeScan scan = form;
    scan.ranges = ranges;
    return scan;
  }
};
[[nodiscard]] SimulatedScan scan_of(const DiffDriveSim& sim, const DiffDriveSimNodeParams& params);

/// Local map of a robot with live sensing. The other components receive each scan one scan period
/// late, which is later than over DDS.
class LiveSensing {
 public:
  explicit LiveSensing(const OctomapBuilderNodeParams& builder);

  /// Adds odometry with timestamp `stamp` received at time t [s]. X_WB is the pose in the odometry
  /// frame.
  void on_odometry(const RobotState& robot, const Pose2& X_WB, double stamp, double t);
  /// Adds a scan at time t [s]. Returns the map as of the previous scan; empty if that scan was not
  /// used.
  std::optional<Grid> look(const RangeScan& scan, const SliceParams& params, double t);
  /// Why the robot must stand, as octomap_builder reports it; empty if the scans are usable.
  [[nodiscard]] std::string trouble(double t) { return watch_.reason(t); }

 private:
  Footprint outline_;
  double sweep_height_;
  Eigen::Isometry3d X_BS_;
  LocalMap map_;
  OwnBody body_;
  ScanReader reader_;
  SensorWatch watch_;
  PoseHistory poses_, odometry_;
  std::optional<Grid> seen_;
};

/// The objects that all drives in one world share.
struct World {
  std::string key;  ///< every input that the world depends on
  std::shared_ptr<const StaticMap> truth, filter_map;
  Extractor extractor;
  std::optional<double> shortest_path;  ///< [m]
};

/// Caches the most recently used worlds.
class Worlds {
 public:
  /// The world of a drive. With live sensing it is built anew each time, because the robot must not
  /// start with shapes from an earlier drive. The reference is valid until kMaxWorlds other worlds,
  /// or with live sensing the same one, have been requested. Throws what slice and load_map throw.
  [[nodiscard]] World& of(const Scenario& scenario, const System& system,
                          const DriveOptions& options);

 private:
  template <class Make>
  World& at(const std::string& key, Make make);

  static constexpr std::size_t kMaxWorlds = 24;
  std::vector<std::unique_ptr<World>> worlds_;
};

}  // namespace tandem
