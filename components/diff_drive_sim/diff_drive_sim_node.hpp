// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>

#include "tandem/config/parameter_text.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim.hpp"
#include "tandem/diff_drive_sim/single_source.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/robot_description.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct DiffDriveSimNodeParams {
  RobotParams robot;
  DiffDriveSimParams sim;
  SliceParams slice;
  Frames frames;
  std::string map;
  bool unknown_is_obstacle = false;
  std::vector<double> start = {0.0, 0.0, 0.0};
  std::vector<double> people;
  int seed = 1;
  double step = 0.01;
  double speed_factor = 1.0;
  double odom_rate = 50.0;
  double scan_rate = 10.0;
  int scan_beams = 360;
  double scan_range = 10.0;
  double scan_angle = kAllAround;
  double scan_noise = 0.0;
  std::string scan_frame = "base_scan";
  bool single_source = true;
  bool publish_description = true;
  StampParams input{.max_stamp_age = 0.0};  // not all senders use the simulated time

  template <class Visitor>
  void visit(Visitor&& field) {
    robot.visit(field);
    sim.visit(field);
    slice.visit(field);
    frames.visit(field);
    field("map", map,
          "OctoMap file (.bt, .ot), map of Nav2's map_server (.yaml) or description (.yaml)");
    field("unknown_is_obstacle", unknown_is_obstacle,
          "true: unknown cells stop the robot like occupied ones");
    field("start", start, Range{-1e5, 1e5}, "[m, m, rad] initial x, y and heading in the map");
    field("people", people, Range{-1e5, 1e5},
          "simulated people, for each: radius [m], speed [m/s], number of points, x1, y1, … [m] of "
          "the path that they walk back and forth");
    field("seed", seed, Range{0, 2147483647},
          "seed of slip and of the noise of odometry and ranges");
    field("step", step, Range{0.001, 0.1},
          "[s] simulated time between two /clock messages; up to twice that while nothing moves");
    field("speed_factor", speed_factor, Range{0.01, 100.0}, "[1] simulated time per real time");
    field("odom_rate", odom_rate, Range{1.0, 1000.0}, "[Hz] rate of odom, tf and ground truth");
    field("scan_rate", scan_rate, Range{0.1, 100.0}, "[Hz] scan rate");
    field("scan_beams", scan_beams, Range{1, 10000}, "beams per scan");
    field("scan_range", scan_range, Range{0.1, 1000.0}, "[m] maximum range of a return");
    field("scan_angle", scan_angle, Range{0.01, 6.2832},
          "[rad] field of view of a scan, centred straight ahead; 2π: all around");
    field("scan_noise", scan_noise, Range{0.0, 1.0}, "[m] standard deviation of a range");
    field("scan_frame", scan_frame, "name of the scanner's frame, 0.3 m above base_link");
    field("single_source", single_source,
          "the base stands while commands of two programs arrive within base_timeout, because one "
          "of them bypasses the safety filter");
    field("publish_description", publish_description,
          "whether the robot's shape is published on robot_description, unless another node does");
    input.visit(field);
  }
};

/// Range of ray `i` of the scan from X_MB [m] as published: +inf without a return.
[[nodiscard]] inline float scan_range_of(const DiffDriveSim& sim,
                                         const DiffDriveSimNodeParams& params, const Pose2& X_MB,
                                         int i) {
  const double range = sim.beam(X_MB, i, params.scan_beams, params.scan_range, params.scan_angle);
  return range < params.scan_range ? static_cast<float>(range)
                                   : std::numeric_limits<float>::infinity();
}

/// X_BS of the scanner.
[[nodiscard]] inline Eigen::Isometry3d scanner_place() {
  return Eigen::Isometry3d{Eigen::Translation3d(0.0, 0.0, 0.3)};
}

/// The people of the parameters. Throws std::invalid_argument as walkers_of does.
[[nodiscard]] inline People people_of(const DiffDriveSimNodeParams& params) {
  return {walkers_of(params.people), People::kAcceleration};
}

/// The map in which the simulator drives. Throws std::invalid_argument without a map file, and what
/// load_map and slice throw.
[[nodiscard]] inline std::shared_ptr<const StaticMap> simulated_world(
    const DiffDriveSimNodeParams& params) {
  if (params.map.empty())
    throw std::invalid_argument("map: give the path of an OctoMap (.bt, .ot) or of a map's YAML");
  return std::make_shared<const StaticMap>(slice(*load_map(params.map), params.slice),
                                           params.unknown_is_obstacle);
}

/// The key under which a rt::ResultCache holds simulated_world().
[[nodiscard]] inline std::string key_of_world(const DiffDriveSimNodeParams& params) {
  return fmt::format("{} {}; {}", file_key(params.map), parameter_text(params.slice),
                     params.unknown_is_obstacle);
}

/// cmd_vel, initialpose → odom, tf, tf_static, ground_truth/odom, people, scan, collision, /clock.
///
/// The scanner turns as a real one does: beams are taken one after the other from the robot's pose
/// at that time, and none outside scan_angle. Runs on the steady clock at `speed_factor`; after a
/// late tick the simulated time runs slower and never jumps. Service: ~/reset (back to the start).
class DiffDriveSimNode {
 public:
  using Params = DiffDriveSimNodeParams;
  explicit DiffDriveSimNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void subscribe();
  void on_command(const Twist2& twist);
  void reset(const Pose2& X_MB);
  void tick();
  void leave_out_next();
  [[nodiscard]] bool is_odometry_due(long tick) const;
  void publish_clock();
  void publish_odometry();
  void publish_ground_truth();
  void publish_frames();
  void turn_scanner();
  [[nodiscard]] float noisy(float range);
  [[nodiscard]] double time_per_beam() const;  // [s]
  void publish_scan();
  void publish_collision();
  void publish_people();
  [[nodiscard]] Stamp stamp_at(double t) const;

  rt::Node& node_;
  rt::Parameters<DiffDriveSimNodeParams> params_;
  DiffDriveSim sim_;
  SingleSource source_;
  long ticks_ = 0;
  int left_out_ = 0;           // ticks before the next call of tick()
  std::vector<float> ranges_;  // ranges of the current turn so far
  double turn_began_ = 0.0;    // [s]
  std::mt19937 scan_random_;
  bool is_heard_ = false;  // whether the current turn had a subscriber when it began

  rt::Publisher<rosgraph_msgs::msg::Clock> clock_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_, ground_truth_;
  rt::Publisher<tf2_msgs::msg::TFMessage> tf_, tf_static_;
  rt::Publisher<sensor_msgs::msg::LaserScan> scan_;
  rt::Publisher<tandem_msgs::msg::Collision> collision_;
  rt::Publisher<tandem_msgs::msg::ObstacleArray> people_;
  std::optional<RobotDescription> description_;
  TwistInput cmd_vel_;
  rt::Subscription initial_pose_;
  rt::Service reset_;
  rt::Timer timer_;
};

}  // namespace tandem
