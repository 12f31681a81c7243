// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/action_server.hpp"

namespace tandem::runtime {
namespace {

constexpr double kExpiryPeriod = 1.0;  // [s] between looks for results to forget

action_msgs::msg::GoalInfo info_of(const TrackedGoal& goal) {
  action_msgs::msg::GoalInfo info;
  info.goal_id(to_msg(goal.id));
  info.stamp(to_stamp(goal.stamp));
  return info;
}

}  // namespace

ServedGoals::ServedGoals(Node& node, const std::string& action, double result_timeout, Hooks hooks)
    : node_{node},
      action_{action},
      hooks_{std::move(hooks)},
      table_{result_timeout},
      status_{node.create_publisher(Topic<action_msgs::msg::GoalStatusArray>{
          parts_of(action).status.c_str(), kActionStatus})},
      cancel_{node.create_service(
          ServiceName<action_msgs::srv::CancelGoal>{parts_of(action).cancel_goal.c_str()},
          [this](const auto& request, auto& response) { cancel(request, response); })},
      expiry_{node.create_wall_timer(kExpiryPeriod, [this] { expire(); })} {}

std::optional<builtin_interfaces::msg::Time> ServedGoals::accept(const GoalId& id) {
  expire();
  const auto stamp = node_.stamp();
  if (table_.accept(id, to_nanoseconds(stamp))) return stamp;
  node_.log().warn_every(1.0, "{}: goal {} is refused: it is known, or there are too many", action_,
                         to_text(id));
  return std::nullopt;
}

void ServedGoals::execute(const GoalId& id) {
  if (table_.execute(id)) publish();
}

bool ServedGoals::finish(const GoalId& id, GoalStatus status) {
  const GoalStatus before = table_.status(id);
  if (table_.finish(id, status, node_.steady_now())) {
    publish();
    return true;
  }
  if (before != GoalStatus::kUnknown && !has_ended(before))
    node_.log().error("{}: a goal that is {} cannot become {}", action_, name(before),
                      name(status));
  return false;
}

void ServedGoals::publish() const {
  action_msgs::msg::GoalStatusArray all;
  for (const TrackedGoal& goal : table_.goals()) {
    auto& status = all.status_list().emplace_back();
    status.goal_info(info_of(goal));
    status.status(static_cast<std::int8_t>(goal.status));
  }
  status_.publish(all);
}

void ServedGoals::cancel(const action_msgs::srv::CancelGoal_Request& request,
                         action_msgs::srv::CancelGoal_Response& response) {
  const auto& asked = request.goal_info();
  const auto selection = table_.to_cancel(asked.goal_id().uuid(), to_nanoseconds(asked.stamp()));
  for (const TrackedGoal& goal : selection.goals)
    if (hooks_.may_cancel(goal.id) && table_.start_canceling(goal.id))
      response.goals_canceling().push_back(info_of(goal));
  const bool none_agreed = !selection.goals.empty() && response.goals_canceling().empty();
  const CancelAnswer answer = none_agreed ? CancelAnswer::kRejected : selection.answer;
  response.return_code(static_cast<std::int8_t>(answer));
  if (!response.goals_canceling().empty()) publish();
}

void ServedGoals::expire() {
  for (const GoalId& id : table_.expire(node_.steady_now())) hooks_.on_expired(id);
}

}  // namespace tandem::runtime
