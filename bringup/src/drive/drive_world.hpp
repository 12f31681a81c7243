// SPDX-License-Identifier: Apache-2.0
// In: a drive's parameters. Out: what stands in its world, and what the robot knows and sees of it.
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

/// Whether the robot goes by what it sees, at least in part.
[[nodiscard]] inline bool is_seen_live(const MapInputParams& params) {
  return params.map_source != "static";
}

/// What stays of the map for a robot with live sensing.
[[nodiscard]] Grid base_of(const DiffDriveSimNodeParams& sim, const MapInputParams& params);

/// The ground that it knows, for unseen_ground_over.
[[nodiscard]] Grid known_ground_of(const DiffDriveSimNodeParams& sim, const MapInputParams& params);

/// A scan of the simulator's scanner.
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

/// Map and shapes of a robot that looks about; what it sees is known to the others one scan later,
/// which is later than over DDS.
class LiveSensing {
 public:
  explicit LiveSensing(const OctomapBuilderNodeParams& builder);

  /// Odometry that is of time `stamp` arrives at time t. X_WB: its own pose.
  void on_odometry(const RobotState& robot, const Pose2& X_WB, double stamp, double t);
  /// Takes in a scan; the result is what the robot has seen before it.
  std::optional<Grid> look(const RangeScan& scan, const SliceParams& params, double t);
  /// Why the robot must stand, as the octomap_builder says it; empty if the scanner sees.
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

/// What is the same for all drives in a world.
struct World {
  std::string key;  ///< all that it was made of
  std::shared_ptr<const StaticMap> truth, filter_map;
  Extractor extractor;
  std::optional<double> shortest_path;
};

/// The last few worlds.
class Worlds {
 public:
  /// The world of the drive; one that the robot has yet to see is a new one each time. Stays until
  /// a few others have been asked for. Throws what slice and load_map throw.
  [[nodiscard]] World& of(const Scenario& scenario, const System& system,
                          const DriveOptions& options);

 private:
  template <class Make>
  World& at(const std::string& key, Make make);

  static constexpr std::size_t kMost = 24;
  std::vector<std::unique_ptr<World>> worlds_;
};

}  // namespace tandem
