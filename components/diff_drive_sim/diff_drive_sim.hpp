// SPDX-License-Identifier: Apache-2.0
// Simulates a differential-drive robot on a static map among people: its motion, contacts, odometry
// and scans.
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

/// The drive, the sensors' errors and the delays of the simulated robot.
struct DiffDriveSimParams {
  DriveParams drive;  ///< wheels, delays and slip
  double max_step = 0.005;
  double sensor_delay_fraction = 1.0;
  double odometry_noise = 0.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    drive.visit(field);
    field("max_step", max_step, Range{0.0005, 0.02}, "[s] maximum integration step");
    field("sensor_delay_fraction", sensor_delay_fraction, Range{0.0, 1.0},
          "[1] actual sensor delay as a fraction of the robot's sensor_delay");
    field("odometry_noise", odometry_noise, Range{0.0, 0.5},
          "[1] constant scale error of each wheel's odometry, drawn from the seed");
  }
};

/// Width of a full-circle scan [rad].
inline constexpr double kAllAround = 2.0 * std::numbers::pi;

/// Direction in B of ray `i` of `beams` [rad]: spaced evenly over `scan_angle` [rad], centred
/// straight ahead, counter-clockwise. In a full-circle scan the last ray lies one step before the
/// first.
[[nodiscard]] inline double beam_angle(int i, int beams, double scan_angle) {
  const bool is_closed = scan_angle > kAllAround - 1e-6;
  return -0.5 * scan_angle + scan_angle * i / std::max(1, is_closed ? beams : beams - 1);
}

/// Current ground truth.
struct SimState {
  double t = 0.0;  ///< [s]
  Pose2 X_MB;      ///< true pose
  Twist2 twist;    ///< over the ground
};

/// The odometry that the base reports now, measured `sensor_delay` ago.
struct OdometryReport {
  double t = 0.0;  ///< time of the measurement
  Pose2 X_WB;      ///< pose in odometry
  Twist2 twist;    ///< from the wheel encoders
  Pose2 X_MW;      ///< a perfect localizer's transform map → odom at that time
};

/// Contacts since the last reset. An episode begins when the outline touches an occupied cell or a
/// person, and ends when it has been clear of both by 0.05 m for 0.5 s. A contact with a person
/// counts as a collision only once the robot itself moves, that is, once one of its points is
/// faster than 0.05 m/s; otherwise it counts as being walked into.
struct ContactReport {
  bool in_contact = false;         ///< an episode is in progress
  unsigned count = 0;              ///< episodes
  unsigned walked_into = 0;        ///< episodes that began with a person walking into the robot
  Eigen::Vector2d p_MQ{0.0, 0.0};  ///< centre of the obstacle touched in the last episode [m]
};

/// A differential-drive robot on a static map among people; deterministic for a seed.
///
/// Contact is exact (polygon against squares). Motion into an occupied cell is blocked: the robot
/// rests at the last contact-free pose and its wheels stop. Motion away is free; a robot that
/// starts inside an obstacle can leave it. People do not block the robot and are not blocked by it:
/// they walk through it.
class DiffDriveSim {
 public:
  /// Throws std::invalid_argument on parameters out of range or without a map.
  DiffDriveSim(const DiffDriveSimParams& params, const RobotParams& robot,
               std::shared_ptr<const StaticMap> map, unsigned seed);

  /// Replaces the people.
  void put(People people) { people_ = std::move(people); }
  /// Puts the robot at rest at X_MB with zero odometry, clears the contacts and returns the people
  /// to their starts. Time continues.
  void reset(const Pose2& X_MB, unsigned seed);
  /// Takes a command sent at time t [s].
  void command(const Twist2& twist, double t) { drive_.command(twist, t); }
  /// Simulates up to time t [s] in steps of at most max_step.
  void advance_to(double t);

  /// The true state.
  [[nodiscard]] const SimState& state() const { return state_; }
  /// Whether nothing moves, neither the robot nor a person, until the next command.
  [[nodiscard]] bool is_at_rest() const { return drive_.is_at_rest() && people_.all().empty(); }
  /// What odometry reports now, with its noise and delay.
  [[nodiscard]] OdometryReport odometry() const;
  /// Contacts since the last reset.
  [[nodiscard]] const ContactReport& contacts() const { return contacts_; }
  /// Smallest gap of the outline to any obstacle since the last reset [m], at most 1.
  [[nodiscard]] double min_clearance() const { return min_clearance_; }
  /// The robot's outline in B.
  [[nodiscard]] const Footprint& footprint() const { return footprint_; }
  /// The simulated people.
  [[nodiscard]] const People& people() const { return people_; }
  [[nodiscard]] People& people() { return people_; }
  /// Range of ray `i` of `beams` (see beam_angle) from the origin of B at X_MB to a wall or a
  /// person [m].
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
  bool counted_ = false;  // the current episode is included in contacts_.count
  double clear_since_ = 0.0;
  double min_clearance_ = 1.0;
  double clearance_bound_ = 0.0;  // lower bound of the true clearance [m]
};

}  // namespace tandem
