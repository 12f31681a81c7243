// SPDX-License-Identifier: Apache-2.0
// Writes small URDFs for tests.
#pragma once

#include <spdlog/fmt/fmt.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "support/temporary_folder.hpp"

namespace tandem::test {

/// A link with one collision geometry, such as R"(<box size="1 1 1"/>)", at `origin`.
inline std::string link(const std::string& name, const std::string& geometry = "",
                        const std::string& origin = R"(xyz="0 0 0")") {
  if (geometry.empty()) return fmt::format(R"(<link name="{}"/>)", name);
  return fmt::format(
      R"(<link name="{}"><collision><origin {}/><geometry>{}</geometry></collision></link>)", name,
      origin, geometry);
}

/// A joint from base_link, or from `parent`; its axis is y.
inline std::string joint(const std::string& name, const std::string& type, const std::string& child,
                         const std::string& origin, const std::string& parent = "base_link",
                         const std::string& axis = "0 1 0") {
  return fmt::format(
      R"(<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin {}/>
         <axis xyz="{}"/><limit lower="-1" upper="1" effort="1" velocity="10"/></joint>)",
      name, type, parent, child, origin, axis);
}

/// Two driven wheels of 0.1 m radius, 0.4 m apart, whose axle is `x` [m] ahead of base_link.
inline std::string wheels(double x = 0.0) {
  const char* const wheel = R"(<cylinder radius="0.1" length="0.02"/>)";
  const char* const turned = R"(rpy="1.5707963 0 0")";
  return link("left", wheel, turned) + link("right", wheel, turned) +
         joint("left_wheel_joint", "continuous", "left", fmt::format(R"(xyz="{} 0.2 0")", x)) +
         joint("right_wheel_joint", "continuous", "right", fmt::format(R"(xyz="{} -0.2 0")", x));
}

/// A base_link of 1 m × 0.6 m, whose middle is 0.1 m ahead of the axle.
inline std::string body() {
  return link("base_link", R"(<box size="1.0 0.6 0.3"/>)", R"(xyz="0.1 0 0.2")");
}

/// A folder with files.
class UrdfFolder {
 public:
  /// Writes a file, in folders if `name` has any, and returns its path.
  std::filesystem::path write(const std::string& name, const std::string& content) {
    const auto file = folder_.path() / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream{file, std::ios::binary} << content;
    return file;
  }
  /// Writes a URDF with these links and joints.
  std::filesystem::path robot(const std::string& links_and_joints) {
    return write("robot.urdf", "<robot name=\"test\">" + links_and_joints + "</robot>");
  }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

}  // namespace tandem::test
