// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/local_planner_node.hpp"

#include <utility>

#include "tandem/io/topics.hpp"
#include "tandem/model/reasons.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {

rt::Interface LocalPlannerNode::interface() {
  return rt::Interface{.subscribes = {topics::obstacles,
                                      {topics::leader_pose, topics::kUserInput},
                                      topics::goal_pose,
                                      topics::filter_status},
                       .publishes = {topics::cmd_vel_shared, topics::plan, topics::user_path,
                                     topics::planner_status}} +
         TwistInput::interface(topics::cmd_vel_user, topics::kUserInput) +
         TwistInput::interface(topics::cmd_vel) + RobotStateInput::interface() +
         Diagnostics::interface();
}

LocalPlannerNode::LocalPlannerNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>(
          {}, [](auto& all) -> auto& { return all.live; },
          [this](const auto& wanted) { change(wanted.live); })},
      method_{method_named(params_->live.method)},
      guidance_{guidance_of(*params_)},
      nmpc_{params_->live.nmpc, params_->robot},
      robot_{node, params_->input},
      cmd_vel_shared_{node.create_publisher(topics::cmd_vel_shared)},
      plan_{node.create_publisher(topics::plan)},
      user_path_{node.create_publisher(topics::user_path)},
      status_out_{node.create_publisher(topics::planner_status)},
      diagnostics_{node, {topics::cmd_vel_shared.name, topics::planner_status.name}},
      leader_stamp_{node, topics::leader_pose.name, params_->stamp},
      on_user_{node, topics::cmd_vel_user, topics::kUserInput, params_->stamp,
               [this](const Twist2& twist) {
                 user_ = {twist, node_.now()};
               }},
      on_command_{node, topics::cmd_vel, params_->stamp, [this](const Twist2& twist) {
                    command_ = {twist, node_.now()};
                  }} {
  for (TwistInput* input : {&on_user_, &on_command_}) input->set_frames(params_->input.frames);
  const auto& goal = params_->goal;
  if (!goal.empty() && goal.size() != 3)
    throw std::invalid_argument("goal: needs three numbers, x, y and heading");
  if (!goal.empty()) X_MG_ = Pose2{goal[0], goal[1], goal[2]};
  status_.method(name(method_));
  subscribe();
  start_timers(params_->live.nmpc.control_period);
}

void LocalPlannerNode::start_timers(double control_period) {
  timer_ = node_.create_timer(control_period, [this] { plan(); });
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
      node_.log().warn_every(1.0, "{} obstacles are not finite ellipses: dropped",
                             obstacles.refused);
    obstacles_ = {std::move(obstacles.all), node_.now()};
  });
  on_leader_ =
      node_.create_subscription(topics::leader_pose, topics::kUserInput, [this](const auto& msg) {
        if (!leader_stamp_.in_time(msg.header().stamp())) return;
        const auto X_MF = robot_.frames().in_map(msg.header(), topics::leader_pose.name);
        if (!X_MF) return;
        if (const auto X_FL = from_msg(msg.pose()))
          leader_ = {compose(*X_MF, *X_FL), node_.now()};
        else
          node_.log().warn_every(1.0, "leader_pose {}: dropped",
                                 fault_of(msg.pose().orientation()));
      });
  on_goal_ = node_.create_subscription(topics::goal_pose, [this](const auto& msg) {
    const auto X_MF = robot_.frames().in_map_by_tf(msg.header(), topics::goal_pose.name);
    if (!X_MF) return;
    if (const auto X_FG = from_msg(msg.pose()))
      X_MG_ = compose(*X_MF, *X_FG);
    else
      node_.log().warn_every(1.0, "goal_pose {}: dropped", fault_of(msg.pose().orientation()));
  });
  on_filter_ = node_.create_subscription(topics::filter_status, [this](const auto& msg) {
    filter_ = {{msg.enforcing(), msg.refused()}, node_.now()};
  });
}

std::optional<Reason> LocalPlannerNode::missing(double now) const {
  const auto unless = [](bool there, Reason reason) {
    return there ? std::nullopt : std::optional{reason};
  };
  if (!obstacles_.fresh(now, params_->obstacle_timeout)) return Reason::kObstaclesSilent;
  switch (method_) {
    case Method::kLeader:
    case Method::kPath:
      return unless(leader_.fresh(now, params_->user_timeout), Reason::kLeaderSilent);
    case Method::kIntention:
      return unless(user_.fresh(now, params_->user_timeout), Reason::kUserSilent);
    case Method::kGoal:
      return unless(X_MG_.has_value(), Reason::kNoGoal);
  }
  return std::nullopt;
}

PlanRequest LocalPlannerNode::request(const RobotState& robot, double now) const {
  const bool in_force = command_.fresh(now, params_->in_force_timeout);
  PlanRequest request;
  request.method = method_;
  request.t = now;
  request.X_MB = robot.X_MB;
  request.command = in_force ? command_.value : Twist2{};
  request.measured = robot.twist;
  request.X_MG = method_ == Method::kGoal ? X_MG_.value_or(Pose2{}) : leader_.value;
  if (user_.fresh(now, params_->user_timeout)) {
    request.user = user_.value;
    request.rests = user_.value == Twist2{};
  }
  request.obstacles = obstacles_.value;
  request.guidance = guidance_;
  if (filter_.fresh(now, params_->in_force_timeout)) {
    request.guarded = filter_.value.enforces;
    request.refused = filter_.value.refuses;
  }
  return request;
}

void LocalPlannerNode::watch_clock(double now) {
  if (std::exchange(last_time_, now) <= now) return;
  obstacles_.forget_later_than(now);
  user_.forget_later_than(now);
  command_.forget_later_than(now);
  filter_.forget_later_than(now);
  leader_.forget_later_than(now);
  nmpc_.reset();
}

void LocalPlannerNode::plan() {
  const double now = node_.now();
  watch_clock(now);
  const auto robot = robot_.state();
  if (!robot) {
    diagnostics_.report_trouble(robot_.missing(), topics::odom.name);
    return stop(robot_.missing());
  }
  if (const auto reason = missing(now)) return stop(*reason);
  planning_ = true;
  standing_for_ = {};
  const PlanRequest plan_request = request(*robot, now);
  publish(nmpc_.solve(plan_request), plan_request);
}

void LocalPlannerNode::watch() {
  if (!planning_) return;
  if (const auto reason = missing(node_.now())) stop(*reason);
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
  status_.status_text(name(plan.status));
  if (plan.status >= PlanStatus::kOptimal)
    diagnostics_.report_well("plans");
  else
    diagnostics_.report_trouble(name(plan.status));
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

// Fills all fields but the status text and the counters since start.
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
  if (std::exchange(standing_for_, reason) != reason)
    node_.log().missing_every(1.0, "standing: {}", reason);
  cmd_vel_shared_.publish(to_msg(Twist2{}));
  write_status({.status = PlanStatus::kRefused, .source = PlanSource::kStanding});
  status_.status_text(reason);
  status_out_.publish(status_);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::LocalPlannerNode, "local_planner")
