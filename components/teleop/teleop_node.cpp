// SPDX-License-Identifier: Apache-2.0
#include "tandem/teleop/teleop_node.hpp"

#include <spdlog/fmt/ranges.h>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kPatience = 0.1;   // [s] of odometry and /tf, which are read when a stick moves
constexpr double kReminder = 10.0;  // [s] between two log lines of the same warning

std::string name_of(const rt::PublisherId& id) { return {id.begin(), id.end()}; }

bool is_empty(const sensor_msgs::msg::Joy& msg) {
  return msg.axes().empty() && msg.buttons().empty();
}

}  // namespace

rt::Interface TeleopNode::interface() {
  return rt::Interface{
             .subscribes = {{topics::joy, topics::kStickInput}, topics::planner_status},
             .publishes = {topics::cmd_vel_user, topics::leader_pose, topics::leader_markers,
                           topics::teleop_status, topics::end_sim}} +
         TwistInput::interface(topics::cmd_vel_user, topics::kUserInput) +
         RobotStateInput::interface() + Diagnostics::interface();
}

TeleopNode::TeleopNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>(
          {}, [](auto& all) -> auto& { return all.teleop.gains; },
          [this](const auto& wanted) { teleop_.set_gains(wanted.teleop.gains); })},
      teleop_{params_->teleop, params_->robot},
      robot_{node, params_->input},
      holder_{params_->teleop.joy_timeout},
      writer_{params_->teleop.joy_timeout},
      rest_{params_->teleop.joy_timeout, params_->teleop.deadman_button >= 0},
      rhythm_{params_->teleop.joy_timeout},
      joy_stamp_{node, topics::joy.name, params_->stamp},
      cmd_vel_user_{node.create_publisher(topics::cmd_vel_user)},
      leader_pose_{node.create_publisher(topics::leader_pose)},
      markers_{node.create_publisher(topics::leader_markers)},
      end_sim_{node.create_publisher(topics::end_sim)},
      status_{node.create_publisher(topics::teleop_status)},
      diagnostics_{node, {topics::teleop_status.name, topics::cmd_vel_user.name}},
      on_twist_{node, topics::cmd_vel_user, topics::kUserInput, params_->stamp,
                [this](const Twist2& twist) { on_twist(twist); }} {
  robot_.may_wait(kPatience);
  diagnostics_.report_well("no stick is ignored");
  joy_ = node.create_subscription(topics::joy, topics::kStickInput,
                                  [this](const auto& msg) { on_joy(msg); });
  planner_ = node.create_subscription(topics::planner_status, [this](const auto& msg) {
    yielded_ = {msg.source() == "yielded", node_.now()};
  });
  time_jump_ = node.on_time_jump([this] { yielded_.reset(); });
}

void TeleopNode::keep_leader_near() {
  teleop_.keep_leader_near(yielded_.value && yielded_.fresh(node_.now(), kPlannerTimeout));
}

void TeleopNode::on_joy(const sensor_msgs::msg::Joy& msg) {
  const std::string sender = msg.header().frame_id() + name_of(joy_.sender());
  if (!joy_stamp_.in_time(msg.header().stamp())) return rest_.keep(sender, node_.now());
  const Stick stick = read_stick(msg.axes(), msg.buttons(), params_->teleop);
  if (!may_drive(msg, sender, stick)) return;
  if (!holder_.counts(sender, stick.deadman, node_.now())) return;
  if (const auto gap = rhythm_.on_message(stick.deadman, node_.now()))
    node_.log().warn_every(kReminder,
                           "joy arrives every {:.2f} s, too rarely for joy_timeout ({} s), so the "
                           "robot stutters; raise the repeat rate of the joystick's driver "
                           "(autorepeat_rate of joy_node), or raise joy_timeout",
                           *gap, params_->teleop.joy_timeout);
  keep_leader_near();
  const auto intent = teleop_.on_stick(stick, robot_pose(), node_.now(), robot_twist());
  if (intent) {
    cmd_vel_user_.publish(to_msg(intent->twist));
    if (intent->X_ML) publish_leader(*intent->X_ML);
  }
  if (stick.end && !end_pressed_) {
    std_msgs::msg::Bool end;
    end.data(true);
    end_sim_.publish(end);
  }
  end_pressed_ = stick.end;
}

// A release always counts. The dashboard publishes an empty joy for a person who has left.
bool TeleopNode::may_drive(const sensor_msgs::msg::Joy& msg, const std::string& sender,
                           const Stick& stick) {
  if (is_empty(msg)) {
    rest_.forget(sender);
    report(sender, "");
    return true;
  }
  const JoyCheck joy = check_joy(msg.axes(), msg.buttons(), params_->teleop);
  const bool rested = rest_.frees(sender, stick.deadman, joy.at_rest, node_.now());
  const bool waits = stick.deadman && !rested;
  const std::string trouble = joy.trouble.empty() && waits ? kNotAtRest : joy.trouble;
  if (!trouble.empty() && troubles_[sender] != trouble)
    node_.log().write_every(
        1.0, rt::LogLevel::kWarn, trouble,
        fmt::format("{}: joy of `{}` has axes {}; deadzone is {}, axis_range {}", trouble,
                    msg.header().frame_id(), msg.axes(), params_->teleop.gains.deadzone,
                    params_->teleop.axis_range));
  if (!joy.remark.empty())
    node_.log().write_every(kOnce, rt::LogLevel::kWarn, joy.remark, joy.remark);
  report(sender, trouble);
  return !stick.deadman || (rested && !joy.beyond_range);
}

// Troubles are kept per sender, so one sender cannot clear another's.
void TeleopNode::report(const std::string& sender, const std::string& trouble) {
  std_msgs::msg::String msg;
  msg.data(trouble);
  if (!trouble.empty() || troubles_.erase(sender) > 0) status_.publish(msg);
  if (troubles_.size() >= kMaxTroubles) troubles_.clear();
  if (!trouble.empty()) troubles_[sender] = trouble;
  if (troubles_.empty())
    diagnostics_.report_well("no stick is ignored");
  else
    diagnostics_.report_trouble(troubles_.begin()->second);
}

void TeleopNode::on_twist(const Twist2& twist) {
  const auto sender = on_twist_.sender();
  if (sender == cmd_vel_user_.id() || !writer_.counts(name_of(sender), true, node_.now())) return;
  keep_leader_near();
  if (const auto X_ML = teleop_.on_twist(twist, robot_pose(), node_.now(), robot_twist()))
    publish_leader(*X_ML);
}

std::optional<Pose2> TeleopNode::robot_pose() {
  const auto robot = robot_.state();
  return robot ? std::optional{robot->X_MB} : std::nullopt;
}

Twist2 TeleopNode::robot_twist() {
  const auto robot = robot_.state();
  return robot ? robot->twist : Twist2{};
}

void TeleopNode::publish_leader(const Pose2& X_ML) {
  const auto map_header = header(node_.stamp(), params_->input.frames.map);
  leader_pose_.publish(to_msg(X_ML, map_header));
  if (const auto X_MB = robot_pose()) markers_.publish(leader_markers(X_ML, *X_MB, map_header));
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::TeleopNode, "teleop")
