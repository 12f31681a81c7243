// SPDX-License-Identifier: Apache-2.0
// Computes the log of a drive from its messages, live or recorded.
#pragma once

#include <cstdint>
#include <msgs.hpp>
#include <optional>

#include "bringup/drive/drive_log.hpp"
#include "bringup/drive/drive_world.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Measures a drive from the messages of the nodes. The drive begins with the first user command
/// or, with the method `goal`, the first plan, so discovery does not count. Time is that of the
/// message timestamps. Counters are taken relative to the start of the drive, because the nodes may
/// have been running long before it.
class DriveObserver {
 public:
  DriveObserver(const Scenario& scenario, const System& system, const DriveWorld& world);

  /// Adds a sample: pose in M and twist of the robot at time t [s].
  void on_robot(const Odometry& robot, double t);
  void on_collision(const tandem_msgs::msg::Collision& msg);
  void on_user(const geometry_msgs::msg::Twist& msg);
  void on_user(const geometry_msgs::msg::TwistStamped& msg) { on_user(msg.twist()); }
  void on_leader(const geometry_msgs::msg::PoseStamped& msg);
  void on_plan(const tandem_msgs::msg::PlannerStatus& msg);
  void on_filter(const tandem_msgs::msg::FilterStatus& msg);
  void on_obstacles(const tandem_msgs::msg::ObstacleArray& msg);

  /// Whether the drive has begun.
  [[nodiscard]] bool driving() const { return driving_; }
  /// Whether the goal was reached or the scenario's time is up.
  [[nodiscard]] bool over() const;
  [[nodiscard]] Progress progress() const;
  /// The log so far.
  [[nodiscard]] DriveLog log() const;

 private:
  Scenario scenario_;
  std::shared_ptr<const StaticMap> map_;
  Footprint footprint_;
  Metrics metrics_;

  DriveLog log_;
  DriveSample sample_;
  bool driving_ = false;
  std::optional<double> first_;  // time of the drive's first sample [s]
  NodeTotal collisions_, walked_into_, interventions_, plans_, fallbacks_, overruns_;
};

}  // namespace tandem
