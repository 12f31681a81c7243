// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tandem/io/diagnostics.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/model/frame_tree.hpp"
#include "tandem/model/robot.hpp"
#include "tandem/octomap_builder/local_map.hpp"
#include "tandem/octomap_builder/mounting.hpp"
#include "tandem/octomap_builder/own_body.hpp"
#include "tandem/octomap_builder/pose_history.hpp"
#include "tandem/octomap_builder/scan_reader.hpp"
#include "tandem/octomap_builder/sensor_watch.hpp"
#include "tandem/octomap_builder/sweep.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct OctomapBuilderNodeParams {
  RobotParams robot;
  SliceParams slice;
  std::vector<double> scan_pose, cloud_pose;
  LocalMapParams map;
  ScanReaderParams scan;
  SensorWatchParams watch;
  RobotStateParams input;
  double period = 0.05;

  template <class Visitor>
  void visit(Visitor&& field) {
    robot.visit(field);
    slice.visit(field);
    map.visit(field);
    scan.visit(field);
    watch.visit(field);
    input.visit(field);
    field("scan_pose", scan_pose, Range{-100.0, 100.0},
          "[m, rad] x, y, z, roll, pitch, yaw of the sensor of `scan` in base_link; empty: from "
          "/tf_static or /tf, by the frame in its header");
    field("cloud_pose", cloud_pose, Range{-100.0, 100.0},
          "[m, rad] x, y, z, roll, pitch, yaw of the sensor of `cloud_in` in base_link; empty: "
          "from /tf_static or /tf, by the frame in its header");
    field("period", period, Range{0.01, 1.0}, "[s] minimum period between two published maps");
  }
};

/// Height at which the outline covers the ground: that of the slice's lowest voxel [m].
[[nodiscard]] inline double sweep_height(const OctomapBuilderNodeParams& params) {
  return params.slice.floor + params.slice.z_min + 0.5 * params.map.resolution;
}

/// scan, cloud_in, odom, tf, tf_static → octomap_local (what the sensors see near the robot now),
/// sensing_status (whether all sensors see), /diagnostics.
///
/// The ground that the outline stands on or sweeps counts as seen: as free ground at the slice's
/// lowest voxel.
///
/// Each beam of a scan is placed at the time given by time_increment, from the robot's pose at that
/// time. The service ~/reset clears the map. octomap_local is published only after a scan or cloud
/// was inserted, so that its silence means that no sensor sees; sensing_status is published with
/// each octomap_local and every kStatusPeriod.
class OctomapBuilderNode {
 public:
  using Params = OctomapBuilderNodeParams;

  static constexpr double kStatusPeriod = 0.1;  ///< [s] of steady time

  explicit OctomapBuilderNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  struct Sensor {
    const char *topic, *parameter;
    std::optional<Eigen::Isometry3d> X_BS;  // from the parameter
    SensorWatch watch;
    std::optional<double> unplaced = {};  // since when its frame is missing in /tf [s]
    std::size_t own_body = 0;             // returns of the last look inside the outline
    bool own_body_told = false;
  };
  // A look before it is assessed and inserted.
  struct Sight {
    WatchedLook watched;
    std::string composition;
    std::vector<Look> looks;
    Stamp stamp;
  };

  void subscribe();
  void on_odometry(double stamp);
  void on_scan(const sensor_msgs::msg::LaserScan& msg);
  void on_cloud(const sensor_msgs::msg::PointCloud2& msg);
  [[nodiscard]] std::optional<Eigen::Isometry3d> place_of(Sensor& sensor,
                                                          const std_msgs::msg::Header& header);
  [[nodiscard]] Placing place_after(const Sensor& sensor, const std_msgs::msg::Header& header,
                                    double after) const;
  [[nodiscard]] std::string why_unplaced(const Sensor& sensor, const std::string& frame,
                                         const Placing& on_robot) const;
  [[nodiscard]] std::optional<Pose2> pose_at(const Stamp& stamp, double after);
  [[nodiscard]] std::optional<Pose2> odometry_at(const Stamp& stamp);
  [[nodiscard]] std::string why_no_pose(const Stamp& stamp);
  void give_up(Sensor& sensor, const char* what, const std::string& why);
  void check_oddities(RangeScan& scan);
  void note_own_body(Sensor& sensor, std::size_t echoes);
  void take(Sensor& sensor, const Sight& sight);
  [[nodiscard]] bool insert(Sensor& sensor, const std::vector<Look>& looks);
  [[nodiscard]] std::string reason();
  void publish_status();
  void warn_of(const std::string& reason);
  void diagnose(const std::string& reason);
  void publish_if_due();

  rt::Node& node_;
  rt::Parameters<OctomapBuilderNodeParams> params_;
  Footprint outline_;
  LocalMap map_;
  OwnBody body_;
  ScanReader reader_;
  Sensor scanner_, camera_;
  PoseHistory poses_, odometry_;  // X_MB; X_WB, which predicts how returns move
  RobotStateInput robot_;
  std::optional<Stamp> unsent_;  // of the newest look that is not yet in a published map
  double sent_ = 0.0;            // node's clock [s]
  double rested_ = 0.0;          // steady clock: earliest time of the next map [s]

  rt::Publisher<octomap_msgs::msg::Octomap> octomap_;
  rt::Publisher<tandem_msgs::msg::SensingStatus> status_;
  Diagnostics diagnostics_;
  rt::Subscription scan_, cloud_;
  rt::Service reset_;
  rt::Timer timer_, status_timer_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
