// SPDX-License-Identifier: Apache-2.0
// Reads a URDF file and places its links.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include <urdf_model/model.h>

namespace tandem {

/// A pose of a URDF as a transform.
[[nodiscard]] Eigen::Isometry3d to_isometry(const urdf::Pose& pose);

/// A link at position 0 of all joints.
struct PlacedLink {
  urdf::LinkConstSharedPtr link;
  Eigen::Isometry3d X_RL;  ///< its frame in the frame of the root link
  std::string body;        ///< the topmost link to which fixed joints connect it
};

/// The links and joints of a URDF file, which form a tree.
class UrdfModel {
 public:
  /// Reads a file. Throws std::runtime_error "FILE: what is wrong", on one line, for a file that
  /// cannot be read, is not XML or not a URDF, contains xacro's macros, or whose joints are not a
  /// tree.
  explicit UrdfModel(std::filesystem::path file);

  /// The robot's name.
  [[nodiscard]] const std::string& name() const { return tree_->getName(); }
  /// Every link by its name.
  [[nodiscard]] const std::map<std::string, PlacedLink>& links() const { return links_; }
  /// Every joint by its name.
  [[nodiscard]] const std::map<std::string, urdf::JointSharedPtr>& joints() const {
    return tree_->joints_;
  }
  /// The link of that name. Throws like fail(), naming all links, if there is none.
  [[nodiscard]] const PlacedLink& link(const std::string& name) const;
  /// The joint of that name. Throws like fail(), naming all joints, if there is none.
  [[nodiscard]] const urdf::Joint& joint(const std::string& name) const;
  /// A joint's frame in the frame of the root link.
  [[nodiscard]] const Eigen::Isometry3d& pose_of(const urdf::Joint& joint) const;
  /// The file that was read.
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

  /// Throws std::runtime_error "FILE: what".
  [[noreturn]] void fail(std::string_view what) const;

 private:
  void place(const urdf::LinkConstSharedPtr& link, const Eigen::Isometry3d& X_RL,
             const std::string& body);

  std::filesystem::path file_;
  std::shared_ptr<const urdf::ModelInterface> tree_;
  std::map<std::string, PlacedLink> links_;
};

}  // namespace tandem
