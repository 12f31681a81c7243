// SPDX-License-Identifier: Apache-2.0
// What a URDF says of a differential-drive robot, in Tandem's terms.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tandem/model/footprint.hpp"

namespace tandem {

/// Which parts of a URDF are what. Empty: found by name.
struct UrdfOptions {
  std::string base_frame = "base_link";      ///< the link in which the outline is given
  std::vector<std::string> left{}, right{};  ///< joints of the driven wheels
  std::string scanner{};                     ///< link of the laser scanner
  std::string camera{};                      ///< link of the depth camera, the frame of its cloud
};

/// Where a sensor is mounted.
struct SensorMount {
  std::string link;        ///< its link
  Eigen::Isometry3d X_BS;  ///< its frame in the base frame
};

/// A kind of sensor: where it is mounted, or, if several links may be meant, their names.
struct UrdfSensor {
  std::optional<SensorMount> mount;
  std::vector<std::string> candidates;  ///< if there are several
};

/// A differential-drive robot as its URDF describes it.
struct UrdfRobot {
  std::string name;
  ConvexPolygon outline;            ///< p_BV; see collision_outline()
  double wheel_separation = 0.0;    ///< [m]
  std::optional<double> max_speed;  ///< [m/s] velocity limit of the wheels × their radius
  UrdfSensor scanner, camera;
  std::vector<std::string> moving;  ///< joints that may change the outline, which is of position 0
};

/// Reads a URDF file. Wheels are continuous joints whose names contain "wheel" and "left" or
/// "right", but not "caster"; the scanner is a link whose name contains "scan", "laser" or "lidar",
/// the camera one with "depth" and "optical". Throws std::runtime_error "FILE: what is wrong", on
/// one line, also if the wheels are not unique, do not turn about the base frame's y axis, or their
/// axle's middle is not at the base frame's origin, about which a differential drive turns.
[[nodiscard]] UrdfRobot read_urdf_robot(const std::filesystem::path& file,
                                        const UrdfOptions& options = {});

}  // namespace tandem
