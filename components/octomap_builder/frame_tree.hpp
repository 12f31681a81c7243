// SPDX-License-Identifier: Apache-2.0
// In: which frame is fixed to which, as /tf_static tells. Out: where one is, seen from another.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>

namespace tandem {

/// Frames that are fixed to each other, each to one parent. Names are compared without a leading
/// slash, as tf2 has none.
class FrameTree {
 public:
  static constexpr std::size_t kMost = 10'000;  ///< frames; further ones are not kept

  /// `child` is fixed at X_PC in `parent`, whatever was said of it before.
  void set(const std::string& parent, const std::string& child, const Eigen::Isometry3d& X_PC) {
    const std::string name = bare(child);
    if (links_.size() < kMost || links_.contains(name)) links_[name] = {bare(parent), X_PC};
  }

  /// X_BF; nothing if no chain of links joins the two frames.
  [[nodiscard]] std::optional<Eigen::Isometry3d> pose(const std::string& base,
                                                      const std::string& frame) const {
    std::map<std::string, Eigen::Isometry3d> above;  // X_AB of each ancestor A of the base
    climb(bare(base), [&](const std::string& name, const Eigen::Isometry3d& X_AB) {
      return !above.emplace(name, X_AB).second;
    });
    std::optional<Eigen::Isometry3d> X_BF;
    climb(bare(frame), [&](const std::string& name, const Eigen::Isometry3d& X_AF) {
      if (const auto common = above.find(name); common != above.end())
        X_BF = common->second.inverse() * X_AF;
      return X_BF.has_value();
    });
    return X_BF;
  }

 private:
  struct Link {
    std::string parent;
    Eigen::Isometry3d X_PC = Eigen::Isometry3d::Identity();
  };

  static std::string bare(const std::string& name) {
    return name.starts_with('/') ? name.substr(1) : name;
  }

  // Visits the frame and its ancestors, each with the frame's pose in it, until `visit` has enough.
  // Links that make a ring end too.
  template <class Visit>
  void climb(std::string name, const Visit& visit) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (std::size_t steps = 0; steps <= links_.size(); ++steps) {
      if (visit(name, X)) return;
      const auto link = links_.find(name);
      if (link == links_.end()) return;
      X = link->second.X_PC * X;
      name = link->second.parent;
    }
  }

  std::map<std::string, Link> links_;
};

}  // namespace tandem
