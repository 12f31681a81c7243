// SPDX-License-Identifier: Apache-2.0
// In: the messages of a drive, live or recorded. Out: its log.
#pragma once

#include <cstdint>
#include <msgs.hpp>
#include <optional>

#include "bringup/drive/drive_log.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Measures a drive by what the nodes say. The drive begins when someone drives, not while the
/// nodes still find each other, and its time is that of the stamps. What the nodes counted before
/// it is none of its own: they may have run for long, and so may a recording that began late.
class DriveObserver {
 public:
  DriveObserver(const Scenario& scenario, const System& system);

  /// Where the robot is, in M, at a time [s]: a sample of the drive.
  void on_robot(const Odometry& robot, double t);
  void on_collision(const tandem_msgs::msg::Collision& msg);
  void on_user(const geometry_msgs::msg::Twist& msg);
  void on_user(const geometry_msgs::msg::TwistStamped& msg) { on_user(msg.twist()); }
  void on_leader(const geometry_msgs::msg::PoseStamped& msg);
  void on_plan(const tandem_msgs::msg::PlannerStatus& msg);
  void on_filter(const tandem_msgs::msg::FilterStatus& msg);
  void on_obstacles(const tandem_msgs::msg::ObstacleArray& msg);

  /// Someone has driven.
  [[nodiscard]] bool driving() const { return driving_; }
  /// The goal was reached, or the time is over.
  [[nodiscard]] bool over() const;
  [[nodiscard]] Progress progress() const;
  /// The log so far.
  [[nodiscard]] DriveLog log() const;

 private:
  Scenario scenario_;
  StaticMap map_;
  Footprint footprint_;
  Metrics metrics_;

  DriveLog log_;
  DriveSample sample_;
  bool driving_ = false;
  std::optional<double> first_;  // time of the drive's first sample [s]
  NodeTotal collisions_, interventions_, plans_, fallbacks_, overruns_;
};

}  // namespace tandem
