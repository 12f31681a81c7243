// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/urdf.hpp"

#include <cmath>
#include <numbers>
#include <sstream>

namespace tandem {
namespace {

constexpr double kBottom = 0.05, kTop = 0.25;             // [m] of the drawn body
constexpr double kEdge = 0.02;                            // [m] thickness of a polygon's edges
constexpr double kWheelRadius = 0.1, kWheelWidth = 0.04;  // [m]
constexpr const char *kBody = "0.2 0.4 0.7 1", *kTyre = "0.1 0.1 0.1 1";  // RGBA

struct Position {
  double x, y, z;  // [m]
};

std::string escaped(const std::string& text) {
  std::string xml;
  for (const char c : text) {
    if (c == '&')
      xml += "&amp;";
    else if (c == '<')
      xml += "&lt;";
    else if (c == '"')
      xml += "&quot;";
    else
      xml += c;
  }
  return xml;
}

// `roll` and `yaw` [rad] of the shape about its own centre `p`.
void write_visual(std::ostream& out, const Position& p, double roll, double yaw,
                  const std::string& shape, const char* color) {
  out << "    <visual>\n"
      << "      <origin xyz=\"" << p.x << ' ' << p.y << ' ' << p.z << "\" rpy=\"" << roll << " 0 "
      << yaw << "\"/>\n"
      << "      <geometry>" << shape << "</geometry>\n"
      << "      <material name=\"" << (color == kBody ? "body" : "tyre") << "\"><color rgba=\""
      << color << "\"/></material>\n"
      << "    </visual>\n";
}

std::string box(double length, double width) {
  std::ostringstream text;
  text << "<box size=\"" << length << ' ' << width << ' ' << kTop - kBottom << "\"/>";
  return text.str();
}

void write_outline(std::ostream& out, const RobotParams& robot) {
  constexpr double kMiddle = (kBottom + kTop) / 2.0;
  const Footprint footprint = footprint_of(robot);
  if (robot.footprint.empty())
    return write_visual(out, {robot.center_x, 0.0, kMiddle}, 0.0, 0.0,
                        box(robot.length, robot.width), kBody);
  for (const ConvexPolygon& part : footprint.parts) {
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Eigen::Vector2d from = part[i], to = part[(i + 1) % part.size()];
      const Eigen::Vector2d middle = (from + to) / 2.0, along = to - from;
      write_visual(out, {middle.x(), middle.y(), kMiddle}, 0.0, std::atan2(along.y(), along.x()),
                   box(along.norm(), kEdge), kBody);
    }
  }
}

void write_wheels(std::ostream& out, const RobotParams& robot) {
  std::ostringstream wheel;
  wheel << "<cylinder radius=\"" << kWheelRadius << "\" length=\"" << kWheelWidth << "\"/>";
  for (const double side : {1.0, -1.0})
    write_visual(out, {0.0, side * robot.wheel_separation / 2.0, kWheelRadius},
                 std::numbers::pi / 2.0, 0.0, wheel.str(), kTyre);
}

}  // namespace

std::string urdf_of(const RobotParams& robot, const std::string& base_frame) {
  std::ostringstream out;
  out << "<?xml version=\"1.0\"?>\n<robot name=\"tandem\">\n  <link name=\"" << escaped(base_frame)
      << "\">\n";
  write_outline(out, robot);
  write_wheels(out, robot);
  out << "  </link>\n</robot>\n";
  return out.str();
}

}  // namespace tandem
