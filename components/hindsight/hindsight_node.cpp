// SPDX-License-Identifier: Apache-2.0
#include "tandem/hindsight/hindsight_node.hpp"

#include <stdexcept>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr unsigned kMarkersEvery = 4;  // commands

}  // namespace

rt::Interface HindsightNode::interface() {
  return TwistInput::interface(topics::cmd_vel_user, topics::kUserInput) +
         MapInput::interface_of_static() + RobotStateInput::interface() +
         rt::Interface{.publishes = {topics::cmd_vel_assisted, topics::hindsight_markers}};
}

HindsightNode::HindsightNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      hindsight_{params_->hindsight, params_->robot},
      robot_{node, params_->input},
      map_{node, params_->map, robot_.frames()},
      assisted_{node.create_publisher(topics::cmd_vel_assisted)},
      markers_{node.create_publisher(topics::hindsight_markers)},
      on_user_{node, topics::cmd_vel_user, topics::kUserInput, params_->stamp,
               [this](const Twist2& twist) { on_user(twist); }} {
  on_user_.set_frames(params_->input.frames);
  if (params_->map.map_source != "static")
    throw std::invalid_argument(
        "map_source: hindsight plans its paths on the complete map; only `static` is supported");
}

void HindsightNode::on_user(const Twist2& user) {
  const auto robot = robot_.state();
  if (const auto map = map_.map(robot); map && map != known_) {
    hindsight_.on_map(*map);
    known_ = map;
  }
  if (!robot || !known_) {
    node_.log().missing_every(1.0, "no assistance yet: {}",
                              known_ ? robot_.missing() : map_.missing());
    return assisted_.publish(to_msg(user));
  }
  const Assistance assistance = hindsight_.assist(robot->X_MB, user, node_.now());
  assisted_.publish(to_msg(assistance.command));
  if (markers_.matched() == 0 || commands_++ % kMarkersEvery != 0) return;
  markers_.publish(goal_markers(hindsight_.goals(), assistance.belief,
                                header(node_.stamp(), params_->input.frames.map)));
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::HindsightNode, "hindsight")
