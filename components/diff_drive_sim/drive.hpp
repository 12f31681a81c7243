// SPDX-License-Identifier: Apache-2.0
// Simulates the wheels of a differential drive from timestamped twist commands.
#pragma once

#include <deque>
#include <random>

#include "tandem/config/params.hpp"
#include "tandem/model/diff_drive.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Behaviour of the simulated base within the bounds that RobotParams declares. A fraction of 1 is
/// the worst case that the robot parameters allow.
struct DriveParams {
  double a_drive = 1.5;
  double alpha_drive = 3.0;
  double brake_factor = 1.0;
  double turn_brake_factor = 1.0;
  double lag_fraction = 1.0;
  double command_delay_fraction = 1.0;
  double slip = 0.0;
  double slip_time = 0.5;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("a_drive", a_drive, Range{0.05, 50.0}, "[m/s²] maximum acceleration of the drive");
    field("alpha_drive", alpha_drive, Range{0.05, 200.0},
          "[rad/s²] maximum angular acceleration of the drive");
    field("brake_factor", brake_factor, Range{1.0, 10.0},
          "[1] actual deceleration as a multiple of the robot's a_brake");
    field("turn_brake_factor", turn_brake_factor, Range{1.0, 10.0},
          "[1] actual angular deceleration as a multiple of the robot's alpha_brake");
    field("lag_fraction", lag_fraction, Range{0.0, 1.0},
          "[1] actual motor lag as a fraction of the robot's motor_lag");
    field("command_delay_fraction", command_delay_fraction, Range{0.0, 1.0},
          "[1] actual command delay as a fraction of the robot's command_delay");
    field("slip", slip, Range{0.0, 0.5},
          "[1] maximum slip: each wheel's travel deviates by up to this fraction");
    field("slip_time", slip_time, Range{0.01, 60.0}, "[s] duration of one slip");
  }
};

/// Wheel level of the base: command delay and time-out, first-order motors with limits, slip.
///
///   dv/dt = clamp((u_v − v) / τ, ±a),   a = a_brake when slowing, a_drive when speeding up  (1)
///
/// and the same for the turn rate. Apart from the clamp, (1) is linear in the wheel speeds.
class Drive {
 public:
  /// A drive at rest. Equal seeds give equal slip.
  Drive(const DriveParams& params, const RobotParams& robot, unsigned seed);

  /// Takes a command sent at time t [s], not before the earlier ones. A non-finite command is
  /// ignored.
  void command(const Twist2& twist, double t);
  /// Advances the wheels from t to t + dt [s]; dt must be short compared to the motor lag.
  void step(double t, double dt);
  /// Stops the wheels at once, as on contact with a wall.
  void stall() { speeds_ = {}; }

  /// Whether the wheels rest, and no command that the drive has taken will move them.
  [[nodiscard]] bool is_at_rest() const;
  /// Rim speeds, as the encoders measure them.
  [[nodiscard]] const WheelSpeeds& speeds() const { return speeds_; }
  /// Twist of the body over the ground: rim speeds after slip.
  [[nodiscard]] Twist2 twist_over_ground() const;

 private:
  void take_commands(double t);
  void draw_slip(double t);

  DriveParams params_;
  RobotParams robot_;
  std::mt19937 random_;
  std::deque<Stamped<Twist2>> queue_;  // not yet in force, by the time of sending
  Stamped<Twist2> in_force_{{}, 0.0};
  WheelSpeeds speeds_;
  WheelSpeeds slip_{1.0, 1.0};  // factors on the travel, 1 ± slip
  double slip_until_ = -1e9;    // so that the first step draws
};

}  // namespace tandem
