// SPDX-License-Identifier: Apache-2.0
// One robot's geometry and limits (bringup/robots/), shared by all components.
#pragma once

#include <string>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// A differential-drive robot: outline, drive and limits. Defaults: Devalla's MiR 100
/// (2020) with its scripts' rate limits (0.1 in 0.25 s); `bringup/robots/mir100.yaml` has others.
struct RobotParams {
  double length = 0.89;
  double width = 0.58;
  double center_x = 0.038;
  std::vector<double> footprint;
  std::vector<double> footprint_parts;
  double wheel_separation = 0.445;
  double v_max = 0.8;
  double v_min = -0.4;
  double w_max = 1.0;
  double a_max = 0.4;
  double alpha_max = 0.4;
  double a_brake = 1.5;
  double alpha_brake = 3.0;
  double motor_lag = 0.05;
  double command_delay = 0.02;
  double sensor_delay = 0.02;
  double base_timeout = 0.1;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("length", length, Range{0.05, 5.0},
          "[m] of the rectangular outline; ignored when footprint is given");
    field("width", width, Range{0.05, 5.0},
          "[m] of the rectangular outline; ignored when footprint is given");
    field("center_x", center_x, Range{-2.0, 2.0},
          "[m] distance of the rectangle's centre ahead of base_link");
    field("footprint", footprint, Range{-5.0, 5.0},
          "[m] x1, y1, x2, y2, … of a convex outline, counter-clockwise, or of several convex "
          "parts in succession; empty: the rectangle");
    field("footprint_parts", footprint_parts, Range{3.0, 100.0},
          "[1] number of vertices of each part of footprint, in order; empty: one part");
    field("wheel_separation", wheel_separation, Range{0.05, 3.0},
          "[m] distance between the wheels");
    field("v_max", v_max, Range{0.0, 5.0}, "[m/s] maximum forward speed");
    field("v_min", v_min, Range{-5.0, 0.0}, "[m/s] maximum backward speed (negative)");
    field("w_max", w_max, Range{0.05, 10.0}, "[rad/s] maximum turn rate");
    field("a_max", a_max, Range{0.05, 10.0}, "[m/s²] comfortable acceleration");
    field("alpha_max", alpha_max, Range{0.05, 30.0}, "[rad/s²] comfortable angular acceleration");
    field("a_brake", a_brake, Range{0.1, 10.0},
          "[m/s²] deceleration that the drive always achieves");
    field("alpha_brake", alpha_brake, Range{0.1, 60.0},
          "[rad/s²] angular deceleration that the drive always achieves");
    field("motor_lag", motor_lag, Range{0.0, 1.0}, "[s] upper bound on the motors' time constant");
    field("command_delay", command_delay, Range{0.0, 1.0},
          "[s] upper bound on the delay from command to motor");
    field("sensor_delay", sensor_delay, Range{0.0, 1.0},
          "[s] upper bound on the age of odometry on arrival");
    field("base_timeout", base_timeout, Range{0.0, 10.0},
          "[s] the base stops by itself after this long without a command; 0: never, which "
          "requires survive_silence: false in the filter");
  }
};

/// The outline described by the parameters. Throws std::invalid_argument, naming parameter, part
/// and vertex, if they contradict each other or polygons() rejects them.
[[nodiscard]] Footprint footprint_of(const RobotParams& robot);

}  // namespace tandem
