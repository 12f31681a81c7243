// SPDX-License-Identifier: Apache-2.0
#include "tandem/shared_dwa/shared_dwa_node.hpp"

#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {

rt::Interface SharedDwaNode::interface() {
  return TwistInput::interface(topics::cmd_vel_user, topics::kUserInput) + MapInput::interface() +
         RobotStateInput::interface() +
         rt::Interface{.publishes = {topics::cmd_vel_shared, topics::planner_status}} +
         Diagnostics::interface();
}

SharedDwaNode::SharedDwaNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      dwa_{params_->dwa, params_->robot},
      robot_{node, params_->input},
      map_{node, params_->map, robot_.frames()},
      cmd_vel_shared_{node.create_publisher(topics::cmd_vel_shared)},
      status_out_{node.create_publisher(topics::planner_status)},
      diagnostics_{node, {topics::cmd_vel_shared.name, topics::planner_status.name}},
      on_user_{node, topics::cmd_vel_user, topics::kUserInput, params_->stamp,
               [this](const Twist2& twist) {
                 user_ = {twist, node_.now()};
               }} {
  on_user_.set_frames(params_->input.frames);
  status_.method("dwa");
  status_.solver("dwa");
  timer_ = node.create_timer(params_->dwa.control_period, [this] { choose(); });
  time_jump_ = node.on_time_jump([this] { user_.reset(); });
}

void SharedDwaNode::choose() {
  const auto robot = robot_.state();
  const auto map = map_.map(robot);
  if (!robot) return stop_in_trouble(robot_.missing(), topics::odom.name);
  if (!map) return stop_in_trouble(map_.missing(), map_.missing_topic());
  if (!user_.fresh(node_.now(), params_->user_timeout)) {
    diagnostics_.report_well(text_of(Reason::kUserSilent));  // waiting for a person is normal
    return stop(text_of(Reason::kUserSilent));
  }
  reasons_.leave();
  const double start = node_.steady_now();
  const DwaChoice choice = dwa_.choose(robot->X_MB, robot->twist, user_.value, *map);
  publish(choice, node_.steady_now() - start);
}

void SharedDwaNode::publish(const DwaChoice& choice, double time) {
  cmd_vel_shared_.publish(to_msg(choice.command));
  status_.header(header(node_.stamp(), params_->input.frames.map));
  status_.status(choice.admissible ? 0 : -1);
  const Reason reason = choice.admissible ? Reason::kArcChosen : Reason::kNothingAdmissible;
  status_.status_text(text_of(reason));
  status_.reason_code(to_msg(reason));
  if (choice.admissible)
    diagnostics_.report_well(text_of(reason));
  else
    diagnostics_.report_trouble(text_of(reason));
  status_.source(choice.admissible ? "solution" : "braking");
  status_.solve_time(time);
  status_.guesses(choice.looked_at);
  status_.cost(choice.cost);
  status_.clearance(choice.clearance);
  status_.cycles(status_.cycles() + 1);
  if (!choice.admissible) status_.fallbacks(status_.fallbacks() + 1);
  status_out_.publish(status_);
}

void SharedDwaNode::stop_in_trouble(const std::string& reason, const char* waits_for) {
  diagnostics_.report_trouble(reason, waits_for);
  stop(reason);
}

void SharedDwaNode::stop(const std::string& reason) {
  reasons_.enter_missing("standing: " + reason);
  cmd_vel_shared_.publish(to_msg(Twist2{}));
  // A new message, because the last choice's clearance would be mistaken for the present one.
  tandem_msgs::msg::PlannerStatus standing;
  standing.method(status_.method());
  standing.solver(status_.solver());
  standing.cycles(status_.cycles());
  standing.fallbacks(status_.fallbacks());
  standing.header(header(node_.stamp(), params_->input.frames.map));
  standing.status(-1);
  standing.status_text(reason);
  standing.reason_code(to_msg(reason_in(reason)));
  standing.source("standing");
  status_out_.publish(standing);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::SharedDwaNode, "shared_dwa")
