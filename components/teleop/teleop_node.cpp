// SPDX-License-Identifier: Apache-2.0
#include "teleop/teleop_node.hpp"

#include "runtime/component.hpp"
#include "topics.hpp"

namespace tandem {

TeleopNode::TeleopNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<TeleopNodeParams>(
          {}, [](auto& all) -> auto& { return all.teleop.gains; },
          [this](const auto& wanted) { teleop_.set_gains(wanted.teleop.gains); })},
      teleop_{params_->teleop},
      robot_{node, params_->input},
      holder_{params_->teleop.joy_timeout},
      joy_stamp_{node, topics::joy.name, params_->stamp},
      cmd_vel_user_{node.create_publisher(topics::cmd_vel_user)},
      leader_pose_{node.create_publisher(topics::leader_pose)},
      markers_{node.create_publisher(topics::leader_markers)},
      end_sim_{node.create_publisher(topics::end_sim)} {
  joy_ = node.create_subscription(topics::joy, topics::kUserInput,
                                  [this](const auto& msg) { on_joy(msg); });
}

void TeleopNode::on_joy(const sensor_msgs::msg::Joy& msg) {
  if (!joy_stamp_.in_time(msg.header().stamp())) return;
  const Stick stick = read_stick(msg.axes(), msg.buttons(), params_->teleop);
  if (!holder_.counts(msg.header().frame_id(), stick.deadman, node_.now())) return;
  const auto robot = robot_.state();
  const auto X_MB = robot ? std::optional{robot->X_MB} : std::nullopt;
  if (const auto intent = teleop_.on_stick(stick, X_MB, node_.now())) publish(*intent);
  if (stick.end && !end_pressed_) {
    std_msgs::msg::Bool end;
    end.data(true);
    end_sim_.publish(end);
  }
  end_pressed_ = stick.end;
}

void TeleopNode::publish(const Intent& intent) {
  cmd_vel_user_.publish(to_msg(intent.twist));
  if (!intent.X_ML) return;
  const auto map_header = header(node_.stamp(), params_->input.frames.map);
  leader_pose_.publish(to_msg(*intent.X_ML, map_header));
  if (const auto robot = robot_.state())
    markers_.publish(leader_markers(*intent.X_ML, robot->X_MB, map_header));
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::TeleopNode, "teleop")
