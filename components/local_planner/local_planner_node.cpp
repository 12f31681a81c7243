// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/local_planner_node.hpp"

#include <utility>

#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/model/urdf.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kPatience = 0.1;  // [s] of what only the planning cycle uses

}  // namespace

rt::Interface LocalPlannerNode::interface() {
  return rt::Interface{.subscribes = {topics::obstacles,
                                      {topics::leader_pose, topics::kUserInput},
                                      topics::goal_pose,
                                      topics::filter_status},
                       .publishes = {topics::cmd_vel_shared, topics::plan, topics::user_path,
                                     topics::planner_status}} +
         TwistInput::interface(topics::cmd_vel_user, topics::kUserInput) +
         TwistInput::interface(topics::cmd_vel) + RobotStateInput::interface() +
         RobotDescription::interface() +
         rt::only_if("serve_actions: true", NavigationActions::interface()) +
         Diagnostics::interface();
}

LocalPlannerNode::LocalPlannerNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>(
          {}, [](auto& all) -> auto& { return all.live; },
          [this](const auto& wanted) { change(wanted.live); })},
      method_{method_named(params_->live.method)},
      inputs_{params_->timeouts, guidance_of(*params_)},
      nmpc_{params_->live.nmpc, params_->robot},
      robot_{node, params_->input},
      cmd_vel_shared_{node.create_publisher(topics::cmd_vel_shared)},
      plan_{node.create_publisher(topics::plan)},
      user_path_{node.create_publisher(topics::user_path)},
      status_out_{node.create_publisher(topics::planner_status)},
      diagnostics_{node, {topics::cmd_vel_shared.name, topics::planner_status.name}},
      leader_stamp_{node, topics::leader_pose.name, params_->stamp},
      on_user_{node, topics::cmd_vel_user, topics::kUserInput, params_->stamp,
               [this](const Twist2& twist) { inputs_.on_user(twist, node_.now()); }},
      on_command_{node, topics::cmd_vel, params_->stamp,
                  [this](const Twist2& twist) { inputs_.on_command(twist, node_.now()); }} {
  for (TwistInput* input : {&on_user_, &on_command_}) {
    input->set_frames(params_->input.frames);
    input->may_wait(kPatience);
  }
  robot_.may_wait(kPatience);
  if (params_->publish_description)
    description_.emplace(node, urdf_of(params_->robot, params_->input.frames.base));
  const auto& goal = params_->goal;
  if (!goal.empty() && goal.size() != 3)
    throw std::invalid_argument("goal: expected three numbers: x, y and heading");
  if (!goal.empty()) inputs_.on_goal({goal[0], goal[1], goal[2]});
  status_.method(name(method_));
  if (params_->navigation.serve_actions)
    navigation_.emplace(NavigationActions::Planner{node, params_->navigation, robot_, inputs_,
                                                   [this] { return method_; }});
  subscribe();
  start_timers(params_->live.nmpc.control_period);
  time_jump_ = node.on_time_jump([this] {
    inputs_.on_time_jump();
    nmpc_.reset();
  });
}

void LocalPlannerNode::start_timers(double control_period) {
  timer_ = node_.create_timer(control_period, [this] { plan(); });
  if (planning_) start_watchdog(control_period);
}

void LocalPlannerNode::start_watchdog(double control_period) {
  watchdog_ = node_.create_timer(control_period / 4, [this] { watch(); });
}

void LocalPlannerNode::change(const LivePlannerParams& wanted) {
  const auto& now = params_->live;
  nmpc_.set_params(wanted.nmpc);
  if (wanted.nmpc.control_period != now.nmpc.control_period)
    start_timers(wanted.nmpc.control_period);
  if (wanted.method == now.method) return;
  nmpc_.reset();  // another method's last plan is no useful warm start
  method_ = method_named(wanted.method);
  status_.method(wanted.method);
}

void LocalPlannerNode::subscribe() {
  on_obstacles_ = node_.create_subscription(topics::obstacles, [this](const auto& msg) {
    const auto X_MF = robot_.frames().in_map(msg.header(), topics::obstacles.name);
    if (!X_MF) return;
    Obstacles obstacles = from_msg(msg);
    for (Obstacle& obstacle : obstacles.all) obstacle = transform(*X_MF, obstacle);
    if (obstacles.refused > 0)
      node_.log().warn_every(1.0, "{} obstacles are {}: dropped", obstacles.refused, kNotValid);
    inputs_.on_obstacles(std::move(obstacles.all), node_.now());
  });
  on_obstacles_.may_wait(kPatience);
  on_leader_ =
      node_.create_subscription(topics::leader_pose, topics::kUserInput, [this](const auto& msg) {
        if (!leader_stamp_.in_time(msg.header().stamp())) return;
        const auto X_MF = robot_.frames().in_map(msg.header(), topics::leader_pose.name);
        if (!X_MF) return;
        if (const auto X_FL = from_msg(msg.pose()))
          inputs_.on_leader(compose(*X_MF, *X_FL), node_.now());
        else
          node_.log().warn_every(1.0, "leader_pose {}: dropped",
                                 fault_of(msg.pose().orientation()));
      });
  on_goal_ = node_.create_subscription(topics::goal_pose, [this](const auto& msg) {
    const auto X_MF = robot_.frames().in_map_by_tf(msg.header(), topics::goal_pose.name);
    if (!X_MF) return;
    const auto X_FG = from_msg(msg.pose());
    if (!X_FG) {
      node_.log().warn_every(1.0, "goal_pose {}: dropped", fault_of(msg.pose().orientation()));
      return;
    }
    if (navigation_) navigation_->on_goal_pose();
    inputs_.on_goal(compose(*X_MF, *X_FG));
  });
  on_filter_ = node_.create_subscription(topics::filter_status, [this](const auto& msg) {
    inputs_.on_filter(msg.enforcing(), msg.refused(), node_.now());
  });
  on_filter_.may_wait(kPatience);
}

void LocalPlannerNode::plan() {
  const double now = node_.now();
  const auto robot = robot_.state();
  if (!robot) {
    diagnostics_.report_trouble(robot_.missing(), topics::odom.name);
    return stop(robot_.missing());
  }
  if (const auto reason = inputs_.missing(method_, now)) return stop(*reason);
  if (!std::exchange(planning_, true)) start_watchdog(params_->live.nmpc.control_period);
  reasons_.leave();
  inputs_.advance(robot->X_MB.position());
  const PlanRequest request = inputs_.request(method_, *robot, now);
  publish(nmpc_.solve(request), request);
}

void LocalPlannerNode::watch() {
  if (const auto reason = inputs_.missing(method_, node_.now())) stop(*reason);
}

// Waiting for a person or a goal is normal and is reported as healthy.
void LocalPlannerNode::stop(Reason reason) {
  if (reason == Reason::kObstaclesSilent)
    diagnostics_.report_trouble(text_of(reason), topics::obstacles.name);
  else
    diagnostics_.report_well(text_of(reason));
  stop(text_of(reason));
}

void LocalPlannerNode::publish(const Plan& plan, const PlanRequest& request) {
  cmd_vel_shared_.publish(to_msg(plan.command));
  write_status(plan);
  write_reason(name(plan.status));
  if (plan.status >= PlanStatus::kOptimal)
    diagnostics_.report_well("plans");
  else
    diagnostics_.report_trouble(name(plan.status));
  if (plan.status == PlanStatus::kRefused)
    node_.log().error_every(1.0, "no plan: a number of the request is not finite in `{}`",
                            params_->input.frames.map);
  status_.cycles(status_.cycles() + 1);
  if (is_fallback(plan.source)) status_.fallbacks(status_.fallbacks() + 1);
  const double budget = params_->live.nmpc.time_budget;
  if (budget > 0.0 && plan.solve_time > budget) status_.overruns(status_.overruns() + 1);
  status_.disagreements(status_.disagreements() + static_cast<std::uint64_t>(plan.disagreements));
  status_out_.publish(status_);
  if (plan.disagreements > 0)
    node_.log().warn_every(1.0, "the second solver does not confirm the plan");
  publish_paths(plan, request);
}

void LocalPlannerNode::write_reason(const std::string& reason) {
  status_.status_text(reason);
  status_.reason_code(to_msg(reason_in(reason)));
}

// Fills all fields but the reason and the counters since start.
void LocalPlannerNode::write_status(const Plan& plan) {
  const bool is_solution = plan.source == PlanSource::kSolution;
  status_.header(header(node_.stamp(), params_->input.frames.map));
  status_.status(static_cast<int>(plan.status));
  status_.source(name(plan.source));
  status_.solver(is_solution ? name(plan.solver) : "");
  status_.verdict(is_solution ? name(plan.verdict) : "");
  status_.solve_time(plan.solve_time);
  status_.iterations(plan.iterations);
  status_.guesses(plan.guesses);
  status_.solves(plan.solves);
  status_.cost(plan.cost);
  status_.cost_pose(plan.parts.pose);
  status_.cost_twist(plan.parts.twist);
  status_.cost_change(plan.parts.change);
  status_.cost_slack(plan.parts.slack);
  status_.active_constraints(plan.active);
  status_.slack(plan.slack);
  status_.clearance(plan.clearance);
}

void LocalPlannerNode::publish_paths(const Plan& plan, const PlanRequest& request) {
  const auto map_header = header(node_.stamp(), params_->input.frames.map);
  if (plan_.matched() > 0) plan_.publish(to_path(plan.X_MB, map_header));
  if (user_path_.matched() == 0) return;
  std::vector<Pose2> forecast{request.X_MB};
  for (int k = 0; k < params_->live.nmpc.horizon_steps; ++k)
    forecast.push_back(integrate(forecast.back(), request.user, params_->live.nmpc.dt));
  user_path_.publish(to_path(forecast, map_header));
}

void LocalPlannerNode::stop(const std::string& reason) {
  planning_ = false;
  watchdog_ = {};
  reasons_.enter_missing("standing: " + reason);
  cmd_vel_shared_.publish(to_msg(Twist2{}));
  write_status({.status = PlanStatus::kRefused, .source = PlanSource::kStanding});
  write_reason(reason);
  status_out_.publish(status_);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::LocalPlannerNode, "local_planner")
