// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "tandem/hindsight/hindsight.hpp"
#include "tandem/io/map_input.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct HindsightNodeParams {
  RobotParams robot;
  HindsightParams hindsight;
  MapInputParams map;
  RobotStateParams input;
  StampParams stamp;

  template <class Visitor>
  void visit(Visitor&& field) {
    robot.visit(field);
    hindsight.visit(field);
    map.visit(field);
    input.visit(field);
    stamp.visit(field);
  }
};

/// cmd_vel_user, octomap_binary, odom, tf → cmd_vel_assisted, hindsight/markers.
///
/// Sits between the person and a planner with method intention, whose cmd_vel_user is remapped to
/// cmd_vel_assisted. Publishes once per command received; while the map or the robot's state is
/// missing it passes the person's command through. Throws std::invalid_argument unless `map_source`
/// is static, because paths are computed on the finished map only.
class HindsightNode {
 public:
  using Params = HindsightNodeParams;
  explicit HindsightNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void on_user(const Twist2& user);

  rt::Node& node_;
  rt::Parameters<HindsightNodeParams> params_;
  Hindsight hindsight_;
  RobotStateInput robot_;
  MapInput map_;
  std::shared_ptr<const StaticMap> known_;
  unsigned commands_ = 0;

  rt::Publisher<geometry_msgs::msg::Twist> assisted_;
  rt::Publisher<visualization_msgs::msg::MarkerArray> markers_;
  TwistInput on_user_;
};

}  // namespace tandem
