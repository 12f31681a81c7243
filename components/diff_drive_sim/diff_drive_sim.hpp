// SPDX-License-Identifier: Apache-2.0
// In: twist commands with times, the static map, people. Out: the robot's motion, contacts,
// odometry, scan.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <deque>
#include <memory>
#include <numbers>
#include <vector>

#include "tandem/diff_drive_sim/drive.hpp"
#include "tandem/diff_drive_sim/people.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

struct DiffDriveSimParams {
  DriveParams drive;
  double max_step = 0.005;
  double sensor_delay_fraction = 1.0;
  double odometry_noise = 0.0;
  double episode_clearance = 0.05;
  double episode_time = 0.5;
  double standing_speed = 0.05;

  template <class Visitor>
  void visit(Visitor&& field) {
    drive.visit(field);
    field("max_step", max_step, Range{0.0005, 0.02}, "[s] longest step of integration");
    field("sensor_delay_fraction", sensor_delay_fraction, Range{0.0, 1.0},
          "[1] of the robot's sensor_delay");
    field("odometry_noise", odometry_noise, Range{0.0, 0.5},
          "[1] scale error of each wheel in the odometry, constant, drawn by seed");
    field("episode_clearance", episode_clearance, Range{0.0, 1.0},
          "[m] a contact ends when clear by this much …");
    field("episode_time", episode_time, Range{0.0, 10.0}, "[s] … for this long");
    field("standing_speed", standing_speed, Range{0.0, 1.0},
          "[m/s] a robot whose fastest point moves no faster stands, and is walked into");
  }
};

/// Width of a scan that has no ends [rad].
inline constexpr double kAllAround = 2.0 * std::numbers::pi;

/// Direction in B of ray `i` of `beams` [rad]: evenly over `scan_angle` [rad], of which the middle
/// is straight ahead, counter-clockwise. All around, the last ray lies one step before the first.
[[nodiscard]] inline double beam_angle(int i, int beams, double scan_angle) {
  const bool is_closed = scan_angle > kAllAround - 1e-6;
  return -0.5 * scan_angle + scan_angle * i / std::max(1, is_closed ? beams : beams - 1);
}

/// Ground truth now.
struct SimState {
  double t = 0.0;
  Pose2 X_MB;
  Twist2 twist;  ///< over the ground
};

/// What the base reports now: measured `sensor_delay` ago.
struct OdometryReport {
  double t = 0.0;  ///< when it was measured
  Pose2 X_WB;
  Twist2 twist;  ///< from the wheel encoders
  Pose2 X_MW;    ///< a perfect localiser's transform map → odom at that time
};

/// Contacts since the last reset. An episode begins when the outline touches an occupied cell or a
/// person and ends when it has been clear of both by episode_clearance for episode_time. With a
/// person it counts from when the robot itself moves, else as being walked into.
struct ContactReport {
  bool in_contact = false;  ///< an episode is open
  unsigned count = 0;
  unsigned walked_into = 0;        ///< episodes that began with a person walking into it
  Eigen::Vector2d p_MQ{0.0, 0.0};  ///< centre of what was touched in the last episode [m]
};

/// A differential-drive robot on a static map, among people; deterministic for a seed.
///
/// Contact is exact (polygon against squares). Motion into a cell is blocked: the robot rests at
/// the last pose free of contact and its wheels stand. Motion away is free. A robot put into an
/// obstacle may leave it. People block nothing: they walk on, through the robot if need be.
class DiffDriveSim {
 public:
  /// Throws std::invalid_argument on parameters out of range or without a map.
  DiffDriveSim(const DiffDriveSimParams& params, const RobotParams& robot,
               std::shared_ptr<const StaticMap> map, unsigned seed);

  /// From now on these people walk there.
  void put(People people) { people_ = std::move(people); }
  /// At rest at X_MB, odometry zero there, contacts forgotten, people back at their starts, time
  /// goes on.
  void reset(const Pose2& X_MB, unsigned seed);
  /// A command sent at time t.
  void command(const Twist2& twist, double t) { drive_.command(twist, t); }
  /// Runs to time t in steps of at most max_step.
  void advance_to(double t);

  [[nodiscard]] const SimState& state() const { return state_; }
  [[nodiscard]] OdometryReport odometry() const;
  [[nodiscard]] const ContactReport& contacts() const { return contacts_; }
  /// Smallest gap of the outline to any obstacle since the last reset [m], at most 1.
  [[nodiscard]] double min_clearance() const { return min_clearance_; }
  [[nodiscard]] const Footprint& footprint() const { return footprint_; }
  [[nodiscard]] const People& people() const { return people_; }
  [[nodiscard]] People& people() { return people_; }
  /// Range of ray `i` of `beams`, at beam_angle, from the origin of B at X_MB to a wall or a person
  /// [m].
  [[nodiscard]] double beam(const Pose2& X_MB, int i, int beams, double max_range,
                            double scan_angle = kAllAround) const;

 private:
  struct Sample {
    double t;
    Pose2 X_WB, X_MB;
    Twist2 twist;
  };

  void step(double dt);
  [[nodiscard]] Pose2 move(double dt);
  [[nodiscard]] bool touches(const Pose2& X_MB) const;
  void touch(const Pose2& X_MB);
  void meet_people();
  void open_episode(const Eigen::Vector2d& p_MQ);
  void update_clearance(double travel);
  void record();

  DiffDriveSimParams params_;
  RobotParams robot_;
  std::shared_ptr<const StaticMap> map_;
  Footprint footprint_;
  double radius_;
  Drive drive_;
  SimState state_;
  WheelSpeeds odometry_scale_;
  Pose2 X_WB_;
  std::deque<Sample> samples_;
  People people_;
  ContactReport contacts_;
  bool counted_ = false;  // the open episode is in contacts_.count
  double clear_since_ = 0.0;
  double min_clearance_ = 1.0;
  double clearance_bound_ = 0.0;  // the true clearance is at least this [m]
};

}  // namespace tandem
