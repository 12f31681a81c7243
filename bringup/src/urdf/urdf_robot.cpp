// SPDX-License-Identifier: Apache-2.0
#include "bringup/urdf/urdf_robot.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "bringup/urdf/collision_outline.hpp"
#include "bringup/urdf/urdf_model.hpp"

namespace tandem {
namespace {

using Names = std::vector<std::string>;

std::string joined(const Names& names) { return fmt::format("{}", fmt::join(names, ", ")); }

std::string lower_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

bool contains(const std::string& name, const char* word) {
  return lower_case(name).find(word) != std::string::npos;
}

bool is_wheel(const urdf::Joint& joint, const char* side) {
  return joint.type == urdf::Joint::CONTINUOUS && contains(joint.name, "wheel") &&
         contains(joint.name, side) && !contains(joint.name, "caster");
}

// Reads one URDF. B is the base frame.
class RobotReader {
 public:
  RobotReader(const std::filesystem::path& file, const UrdfOptions& options)
      : model_{file}, options_{options}, base_{model_.link(options.base_frame)} {}

  UrdfRobot read() {
    const Names left = wheels(options_.left, "left"), right = wheels(options_.right, "right");
    UrdfRobot robot;
    robot.name = model_.name();
    robot.outline = collision_outline(model_, base_.X_RL);
    robot.wheel_separation = separation(left, right);
    robot.max_speed = max_speed(left, right);
    robot.scanner = sensor(options_.scanner, {{"scan"}, {"laser"}, {"lidar"}});
    robot.camera = sensor(options_.camera, {{"depth", "optical"}});
    robot.moving = moving();
    return robot;
  }

 private:
  [[nodiscard]] Eigen::Isometry3d in_base(const Eigen::Isometry3d& X_RQ) const {
    return base_.X_RL.inverse() * X_RQ;
  }
  [[nodiscard]] Eigen::Vector3d axis_in_base(const urdf::Joint& joint) const {
    const Eigen::Vector3d axis{joint.axis.x, joint.axis.y, joint.axis.z};
    return in_base(model_.pose_of(joint)).linear() * axis.normalized();
  }

  [[nodiscard]] Names wheels(const Names& given, const char* side) const {
    const Names names = given.empty() ? found_wheels(side) : given;
    for (const std::string& name : names) check_axis(model_.joint(name));
    return names;
  }

  // The one wheel on that side, by its name.
  [[nodiscard]] Names found_wheels(const char* side) const {
    Names names, continuous;
    for (const auto& [name, joint] : model_.joints()) {
      if (is_wheel(*joint, side)) names.push_back(name);
      if (joint->type == urdf::Joint::CONTINUOUS) continuous.push_back(name);
    }
    if (names.size() == 1) return names;
    const std::string what =
        names.empty() ? fmt::format("no continuous joint is called {} wheel; there are: [{}]", side,
                                    joined(continuous))
                      : fmt::format("several joints are called {} wheel: {}", side, joined(names));
    model_.fail(what + ". Name the driven ones with --left and --right");
  }

  void check_axis(const urdf::Joint& wheel) const {
    constexpr double kAlong = 0.99;  // cosine of 8°
    if (wheel.type != urdf::Joint::FIXED && std::abs(axis_in_base(wheel).y()) < kAlong)
      model_.fail(
          fmt::format("joint '{}' does not turn about the y axis of {}, whose x axis must "
                      "point forward",
                      wheel.name, options_.base_frame));
  }

  [[nodiscard]] Eigen::Vector3d middle(const Names& wheels) const {
    Eigen::Vector3d sum{0.0, 0.0, 0.0};
    for (const std::string& name : wheels)
      sum += in_base(model_.pose_of(model_.joint(name))).translation();
    return sum / static_cast<double>(wheels.size());
  }

  [[nodiscard]] double separation(const Names& left, const Names& right) const {
    constexpr double kTolerance = 0.005;  // [m]
    const Eigen::Vector3d p_BL = middle(left), p_BR = middle(right), p_BA = 0.5 * (p_BL + p_BR);
    if (p_BL.y() <= p_BR.y())
      model_.fail(fmt::format("{} is not to the left of {} in {}", joined(left), joined(right),
                              options_.base_frame));
    if (p_BA.head<2>().norm() > kTolerance)
      model_.fail(
          fmt::format("the middle of the axle ({} and {}) is at ({:.3f}, {:.3f}) in {}, but the "
                      "robot turns about "
                      "its base frame's origin; name the link at the axle with --base-frame",
                      joined(left), joined(right), p_BA.x(), p_BA.y(), options_.base_frame));
    return p_BL.y() - p_BR.y();
  }

  // nullopt if the limit or the radius of a wheel is missing.
  [[nodiscard]] std::optional<double> max_speed(const Names& left, const Names& right) const {
    std::optional<double> least;
    for (const Names* side : {&left, &right})
      for (const std::string& name : *side) {
        const auto speed = max_speed(model_.joint(name));
        if (!speed) return std::nullopt;
        least = std::min(least.value_or(*speed), *speed);
      }
    return least;
  }

  [[nodiscard]] std::optional<double> max_speed(const urdf::Joint& wheel) const {
    const auto& collision = model_.link(wheel.child_link_name).link->collision;
    if (!wheel.limits || !(wheel.limits->velocity > 0.0) || !collision) return std::nullopt;
    const urdf::Geometry& shape = *collision->geometry;
    if (shape.type == urdf::Geometry::CYLINDER)
      return wheel.limits->velocity * static_cast<const urdf::Cylinder&>(shape).radius;
    if (shape.type == urdf::Geometry::SPHERE)
      return wheel.limits->velocity * static_cast<const urdf::Sphere&>(shape).radius;
    return std::nullopt;
  }

  // A link that is meant by its name contains all words of one of the `kinds`.
  [[nodiscard]] UrdfSensor sensor(const std::string& given,
                                  const std::vector<std::vector<const char*>>& kinds) const {
    UrdfSensor sensor;
    if (!given.empty()) {
      const PlacedLink& placed = model_.link(given);
      if (placed.body != base_.body)
        model_.fail(fmt::format(
            "link '{}' moves against {}: joint '{}' is not fixed; publish it on /tf", given,
            options_.base_frame, model_.link(placed.body).link->parent_joint->name));
      sensor.mount = SensorMount{given, in_base(placed.X_RL)};
      return sensor;
    }
    for (const auto& [name, placed] : model_.links()) {
      const auto has_all = [&name = name](const auto& words) {
        return std::all_of(words.begin(), words.end(),
                           [&](const char* word) { return contains(name, word); });
      };
      if (placed.body == base_.body && std::any_of(kinds.begin(), kinds.end(), has_all))
        sensor.candidates.push_back(name);
    }
    if (sensor.candidates.size() != 1) return sensor;
    const std::string& only = sensor.candidates.front();
    return {.mount = SensorMount{only, in_base(model_.link(only).X_RL)}, .candidates = {}};
  }

  // A wheel does not change the outline, but the fork of a caster does.
  [[nodiscard]] Names moving() const {
    constexpr double kHorizontal = 0.1;  // sine of 6°
    Names names;
    for (const auto& [name, joint] : model_.joints()) {
      const bool rolls = joint->type == urdf::Joint::CONTINUOUS &&
                         std::abs(axis_in_base(*joint).z()) < kHorizontal;
      if (joint->type != urdf::Joint::FIXED && !rolls) names.push_back(name);
    }
    return names;
  }

  UrdfModel model_;
  const UrdfOptions& options_;
  const PlacedLink& base_;
};

}  // namespace

UrdfRobot read_urdf_robot(const std::filesystem::path& file, const UrdfOptions& options) {
  return RobotReader{file, options}.read();
}

}  // namespace tandem
