// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/robot_command.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "bringup/urdf/urdf_robot.hpp"
#include "tandem/config/printable.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {
namespace {

struct RobotRequest {
  std::string urdf;
  UrdfOptions options;
};

// The parameters that a URDF gives, and their names.
struct Geometry {
  RobotParams robot;
  std::vector<std::string> given;
};

// Rounded to 0.1 mm or 10⁻⁴ rad, without trailing zeros.
std::string text_of(double value) {
  return fmt::format("{}", std::round(value * 1e4) / 1e4 + 0.0);  // + 0.0: not −0
}

std::string text_of(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(text_of(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string joined(const std::vector<std::string>& names) {
  return printable(fmt::format("{}", fmt::join(names, ", ")));
}

// Whether the outline is the rectangle that length, width and center_x describe; sets them.
bool take_rectangle(const ConvexPolygon& outline, RobotParams& robot) {
  Eigen::Vector2d low = outline.front(), high = low;
  for (const auto& p : outline) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const bool has_its_corners = std::all_of(outline.begin(), outline.end(), [&](const auto& p) {
    return (p.x() == low.x() || p.x() == high.x()) && (p.y() == low.y() || p.y() == high.y());
  });
  if (outline.size() != 4 || !has_its_corners || low.y() != -high.y()) return false;
  robot.length = high.x() - low.x();
  robot.width = high.y() - low.y();
  robot.center_x = 0.5 * (low.x() + high.x());
  return true;
}

// Throws what a node would throw for the file, so that the file is not made in the first place.
Geometry geometry_of(const UrdfRobot& urdf) {
  Geometry geometry;
  RobotParams& robot = geometry.robot;
  robot.wheel_separation = urdf.wheel_separation;
  if (take_rectangle(urdf.outline, robot)) {
    geometry.given = {"length", "width", "center_x", "wheel_separation"};
  } else {
    geometry.given = {"footprint", "wheel_separation"};
    for (const auto& p : urdf.outline)
      robot.footprint.insert(robot.footprint.end(), {p.x(), p.y()});
  }
  // A default must not be faster than the wheels.
  if (urdf.max_speed && *urdf.max_speed < robot.v_max) {
    robot.v_max = *urdf.max_speed;
    geometry.given.push_back("v_max");
  }
  if (urdf.max_speed && *urdf.max_speed < -robot.v_min) {
    robot.v_min = -*urdf.max_speed;
    geometry.given.push_back("v_min");
  }
  check(robot);
  (void)footprint_of(robot);
  return geometry;
}

// Prints the parameters that are given, or the others as comments, which a person completes.
struct ParameterPrinter {
  const Geometry& geometry;
  bool given;

  template <class Value>
  void operator()(const std::string& name, const Value& value, const Range& /*range*/,
                  const char* meaning) const {
    const auto& names = geometry.given;
    const bool is_given = std::find(names.begin(), names.end(), name) != names.end();
    if (is_given && given) std::printf("    %s: %s\n", name.c_str(), text_of(value).c_str());
    if (!is_given && !given && !is_outline(name))
      std::printf("    # %s: %s  # %s\n", name.c_str(), text_of(value).c_str(), meaning);
  }

 private:
  static bool is_outline(const std::string& name) {
    return name == "length" || name == "width" || name == "center_x" ||
           name.starts_with("footprint");
  }
};

void print_robot(const UrdfRobot& urdf, Geometry geometry) {
  std::printf("/**:\n  ros__parameters:\n");
  if (!urdf.moving.empty())
    std::printf("    # The outline is that of position 0 of these joints: %s.\n",
                joined(urdf.moving).c_str());
  geometry.robot.visit(ParameterPrinter{geometry, true});
  std::printf("    # A URDF does not contain these. Until you set them, these defaults hold:\n");
  if (urdf.max_speed)
    std::printf("    # (the wheels' velocity limits allow %s m/s)\n",
                text_of(*urdf.max_speed).c_str());
  geometry.robot.visit(ParameterPrinter{geometry, false});
}

// Roll, pitch and yaw as in a URDF: about the fixed axes x, y and z.
std::vector<double> numbers_of(const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();
  const Eigen::Vector3d p = X.translation();
  return {p.x(),
          p.y(),
          p.z(),
          std::atan2(R(2, 1), R(2, 2)),
          std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
          std::atan2(R(1, 0), R(0, 0))};
}

void print_sensor(const char* parameter, const char* option, const UrdfSensor& sensor) {
  if (sensor.mount)
    std::printf("#     %s: %s  # %s\n", parameter, text_of(numbers_of(sensor.mount->X_BS)).c_str(),
                printable(sensor.mount->link).c_str());
  else if (!sensor.candidates.empty())
    std::printf("#     %s: several links may be meant; name one with %s: %s\n", parameter, option,
                joined(sensor.candidates).c_str());
}

// As a comment, because it overrides /tf_static, and the simulator's scanner is mounted elsewhere.
void print_sensors(const UrdfSensor& scanner, const UrdfSensor& camera) {
  const auto is_there = [](const UrdfSensor& sensor) {
    return sensor.mount || !sensor.candidates.empty();
  };
  if (!is_there(scanner) && !is_there(camera)) return;
  std::printf(
      "# Sensors; only for a real robot on which nothing publishes these frames on /tf_static:\n"
      "# octomap_builder:\n#   ros__parameters:\n");
  print_sensor("scan_pose", "--scanner", scanner);
  print_sensor("cloud_pose", "--camera", camera);
}

void run(const RobotRequest& request) {
  const UrdfRobot urdf = read_urdf_robot(request.urdf, request.options);
  Geometry geometry;
  try {
    geometry = geometry_of(urdf);
  } catch (const std::exception& error) {
    throw std::runtime_error(request.urdf + ": " + error.what());
  }
  std::printf("# %s, made of %s by `tandem robot`.\n", printable(urdf.name).c_str(),
              printable(std::filesystem::path{request.urdf}.filename()).c_str());
  print_robot(urdf, geometry);
  print_sensors(urdf.scanner, urdf.camera);
}

}  // namespace

void add_robot_command(CLI::App& app) {
  auto* command =
      app.add_subcommand("robot", "Make a robot file of a URDF: outline, wheels and sensors");
  auto request = std::make_shared<RobotRequest>();
  UrdfOptions& options = request->options;
  command->add_option("urdf", request->urdf, "URDF file, without macros of xacro")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--base-frame", options.base_frame, "link in the middle of the drive axle")
      ->capture_default_str();
  command->add_option("--left", options.left, "joints of the driven wheels on the left");
  command->add_option("--right", options.right, "joints of the driven wheels on the right");
  command->add_option("--scanner", options.scanner, "link of the laser scanner");
  command->add_option("--camera", options.camera, "link in which a depth camera gives its cloud");
  command->footer(
      "Prints the file. The outline is the convex hull of the collision geometry of all links, "
      "seen "
      "from above: boxes, cylinders, spheres, and the box around each STL mesh. Without options, "
      "the "
      "wheels are the continuous joints called left and right wheel, the scanner is the link "
      "called "
      "scan, laser or lidar, and the camera the one called depth optical. Limits and delays are "
      "not "
      "in a URDF: see `tandem measure`.");
  command->callback([request] { run(*request); });
}

}  // namespace tandem
