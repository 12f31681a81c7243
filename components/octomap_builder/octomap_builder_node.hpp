// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "octomap_builder/local_map.hpp"
#include "octomap_builder/mounting.hpp"
#include "octomap_builder/pose_history.hpp"
#include "robot_state_input.hpp"
#include "runtime/node.hpp"

namespace tandem {

struct OctomapBuilderNodeParams {
  std::vector<double> scan_pose = {0.0, 0.0, 0.3, 0.0, 0.0, 0.0};
  std::vector<double> cloud_pose = scan_pose;
  LocalMapParams map;
  RobotStateParams input;
  double period = 0.05;

  template <class Visitor>
  void visit(Visitor&& field) {
    map.visit(field);
    input.visit(field);
    field("scan_pose", scan_pose, Range{-100.0, 100.0},
          "[m, rad] x, y, z, roll, pitch, yaw of the frame of `scan` in base_link");
    field("cloud_pose", cloud_pose, Range{-100.0, 100.0},
          "[m, rad] x, y, z, roll, pitch, yaw of the frame of `cloud_in` in base_link");
    field("period", period, Range{0.01, 1.0}, "[s] at least, between two maps");
  }
};

/// scan, cloud_in, odom, tf → octomap_local: what is seen near the robot now.
///
/// Service ~/reset forgets all that was seen. Speaks only after a scan or cloud was taken in, so
/// that its silence says that nobody looks.
class OctomapBuilderNode {
 public:
  explicit OctomapBuilderNode(rt::Node& node);

 private:
  void subscribe();
  void insert(const char* topic, const Echoes& echoes, const std_msgs::msg::Header& header,
              const Eigen::Isometry3d& X_BS);
  [[nodiscard]] std::optional<Pose2> pose_at(const Stamp& stamp);
  void publish_if_due();

  rt::Node& node_;
  rt::Parameters<OctomapBuilderNodeParams> params_;
  LocalMap map_;
  Eigen::Isometry3d X_BScan_, X_BCloud_;
  PoseHistory poses_;
  RobotStateInput robot_;
  std::optional<Stamp> unsent_;  // of the newest look that no map was sent with
  double sent_ = 0.0;            // node's clock [s]

  rt::Publisher<octomap_msgs::msg::Octomap> octomap_;
  rt::Subscription scan_, cloud_;
  rt::Service reset_;
  rt::Timer timer_;
};

}  // namespace tandem
