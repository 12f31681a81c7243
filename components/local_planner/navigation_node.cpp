// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/navigation_node.hpp"

#include <cmath>
#include <utility>

namespace tandem {
namespace {

constexpr double kLongestPath = 1000.0;  // [m]
constexpr double kMoves = 0.05;          // [m/s] from which on a time can be estimated

// Nav2's error codes of an action's result.
struct Codes {
  int unknown, no_transform;
};

Codes codes_of(const nav2_msgs::action::NavigateToPose&) {
  namespace codes = nav2_msgs::action::NavigateToPose_Result_Constants;
  return {codes::UNKNOWN, codes::TF_ERROR};
}

Codes codes_of(const nav2_msgs::action::FollowPath&) {
  namespace codes = nav2_msgs::action::FollowPath_Result_Constants;
  return {codes::UNKNOWN, codes::TF_ERROR};
}

constexpr int kNoError = 0;

builtin_interfaces::msg::Duration duration(double seconds) {
  builtin_interfaces::msg::Duration msg;
  msg.sec(static_cast<std::int32_t>(seconds));
  msg.nanosec(static_cast<std::uint32_t>((seconds - std::floor(seconds)) * 1e9));
  return msg;
}

double length_of(const std::vector<Pose2>& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    sum += (path[i].position() - path[i - 1].position()).norm();
  return sum;
}

}  // namespace

NavigationActions::NavigationActions(Planner planner)
    : planner_{std::move(planner)},
      input_{planner_.node},
      to_pose_{actions::navigate_to_pose.name, Method::kGoal},
      along_path_{actions::follow_path.name, Method::kPath} {
  serve(to_pose_, actions::navigate_to_pose);
  serve(along_path_, actions::follow_path);
  input_.on_arbitration([this] { go_on(); });
  timer_ = planner_.node.create_wall_timer(kPeriod, [this] { go_on(); });
}

rt::Interface NavigationActions::interface() {
  // The planner subscribes to the safety filter's status with or without actions.
  return {.subscribes = {topics::arbitration_status},
          .serves_actions = {actions::navigate_to_pose, actions::follow_path}};
}

template <class A>
void NavigationActions::serve(Served<A>& served, const rt::ActionName<A>& action) {
  served.server = planner_.node.create_action_server(
      action, rt::ActionHandlers<A>{
                  .on_goal = [this, &served](const auto& goal) { return consider(served, goal); },
                  .on_cancel =
                      [this, &served](const auto& goal) {
                        if (goal.id() == served.goal.id()) planner_.inputs.drop_goals();
                        return true;
                      },
                  .on_accepted = [this, &served](auto goal) { begin(served, std::move(goal)); }});
}

NavigationState NavigationActions::state() const {
  NavigationState state = input_.state();
  state.method = name(planner_.method());
  if (!planner_.robot.state()) state.not_localized = planner_.robot.missing();
  return state;
}

template <class A>
rt::GoalAnswer NavigationActions::consider(Served<A>& served, const typename A::Goal& goal) {
  const NavigationState now = state();
  const char* method = name(served.method);
  if (const auto hindrance = hindrance_to(method, now)) {
    planner_.node.log().warn("{}: goal rejected: {}", served.name,
                             in_words(*hindrance, method, now));
    return rt::GoalAnswer::kReject;
  }
  auto way = way_of(goal);
  if (!way) return rt::GoalAnswer::kReject;  // way_of() logs why
  served.way = *std::move(way);
  return rt::GoalAnswer::kExecute;
}

template <class A>
void NavigationActions::begin(Served<A>& served, rt::ServerGoal<A> goal) {
  end(served, rt::GoalStatus::kAborted, kNoError, "replaced by a new goal");
  served.goal = std::move(goal);
  served.begun = planner_.node.now();
  give(served);
  planner_.node.log().info("{}: goal accepted", served.name);
}

// Does nothing without a goal in force.
template <class A>
void NavigationActions::end(Served<A>& served, rt::GoalStatus status, int code,
                            const std::string& why) {
  if (!served.goal.is_active()) return;
  planner_.inputs.drop_goals();
  typename A::Result result;
  result.error_code(static_cast<std::uint16_t>(code));
  result.error_msg(status == rt::GoalStatus::kSucceeded ? "" : why);
  const auto goal = std::exchange(served.goal, {});
  if (status == rt::GoalStatus::kSucceeded) goal.succeed(result);
  if (status == rt::GoalStatus::kCanceled) goal.canceled(result);
  if (status == rt::GoalStatus::kAborted) goal.abort(result);
  planner_.node.log().info("{}: goal {}: {}", served.name, name(status), why);
}

void NavigationActions::on_goal_pose() {
  end(to_pose_, rt::GoalStatus::kAborted, kNoError, "replaced by goal_pose");
}

void NavigationActions::go_on() {
  go_on(to_pose_);
  go_on(along_path_);
}

template <class A>
void NavigationActions::go_on(Served<A>& served) {
  if (!served.goal.is_active()) return;
  if (served.goal.is_canceling())
    return end(served, rt::GoalStatus::kCanceled, kNoError, "a client asked for it");
  const NavigationState now = state();
  const Codes codes = codes_of(A{});
  const char* method = name(served.method);
  if (const auto hindrance = hindrance_to(method, now))
    return end(
        served, rt::GoalStatus::kAborted,
        *hindrance == NavigationHindrance::kNotLocalized ? codes.no_transform : codes.unknown,
        in_words(*hindrance, method, now));
  if (planner_.params.goal_needs_client && !served.goal.has_client())
    return end(served, rt::GoalStatus::kAborted, codes.unknown, "its client has left");
  const auto robot = planner_.robot.state();
  if (!robot) return;
  served.goal.publish_feedback(feedback_of(served, *robot));
  if (distance_left(served, robot->X_MB) <= planner_.params.goal_distance &&
      is_reached(robot->X_MB, robot->twist, served.way.back(), planner_.params))
    end(served, rt::GoalStatus::kSucceeded, kNoError, "reached");
}

std::optional<std::vector<Pose2>> NavigationActions::way_of(const ToPose::Goal& goal) const {
  const auto& msg = goal.pose();
  const auto X_MF = planner_.robot.frames().in_map_by_tf(msg.header(), to_pose_.name);
  if (!X_MF) return std::nullopt;
  const auto X_FG = from_msg(msg.pose());
  if (X_FG) return std::vector{compose(*X_MF, *X_FG)};
  planner_.node.log().warn("{}: goal rejected: the pose {}", to_pose_.name,
                           fault_of(msg.pose().orientation()));
  return std::nullopt;
}

std::optional<std::vector<Pose2>> NavigationActions::way_of(const AlongPath::Goal& goal) const {
  const auto& msg = goal.path();
  const auto X_MF = planner_.robot.frames().in_map_by_tf(msg.header(), along_path_.name);
  if (!X_MF) return std::nullopt;
  std::vector<Pose2> path;
  for (const auto& pose : msg.poses()) {
    const auto X_FP = from_msg(pose.pose());
    if (!X_FP) {
      planner_.node.log().warn("{}: goal rejected: a pose {}", along_path_.name,
                               fault_of(pose.pose().orientation()));
      return std::nullopt;
    }
    path.push_back(compose(*X_MF, *X_FP));
  }
  if (!path.empty() && length_of(path) <= kLongestPath) return path;
  planner_.node.log().warn("{}: goal rejected: the path is {}", along_path_.name,
                           path.empty() ? "empty" : "longer than 1 km");
  return std::nullopt;
}

void NavigationActions::give(const Served<ToPose>& served) const {
  planner_.inputs.on_goal(served.way.back());
}

void NavigationActions::give(const Served<AlongPath>& served) const {
  planner_.inputs.on_path(served.way);
}

double NavigationActions::distance_left(const Served<ToPose>& served, const Pose2& X_MB) const {
  return (served.way.back().position() - X_MB.position()).norm();
}

double NavigationActions::distance_left(const Served<AlongPath>&, const Pose2&) const {
  return planner_.inputs.path_left();
}

NavigationActions::ToPose::Feedback NavigationActions::feedback_of(const Served<ToPose>& served,
                                                                   const RobotState& robot) const {
  const double left = distance_left(served, robot.X_MB), speed = std::abs(robot.twist.v);
  ToPose::Feedback feedback;
  feedback.current_pose(
      to_msg(robot.X_MB, header(planner_.node.stamp(), planner_.robot.frames().names().map)));
  feedback.navigation_time(duration(planner_.node.now() - served.begun));
  if (speed > kMoves) feedback.estimated_time_remaining(duration(left / speed));
  feedback.distance_remaining(static_cast<float>(left));
  return feedback;
}

NavigationActions::AlongPath::Feedback NavigationActions::feedback_of(
    const Served<AlongPath>& served, const RobotState& robot) const {
  AlongPath::Feedback feedback;
  feedback.distance_to_goal(static_cast<float>(distance_left(served, robot.X_MB)));
  feedback.speed(static_cast<float>(robot.twist.v));
  return feedback;
}

}  // namespace tandem
