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
/// Between the person and a planner of method intention, which reads cmd_vel_assisted by remapping.
/// Each command is answered at once; while map or robot are not known the person's own goes on.
/// Ways are found on the finished map only: `map_source` has to be static.
class HindsightNode {
 public:
  explicit HindsightNode(rt::Node& node);

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
