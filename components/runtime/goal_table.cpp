// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/goal_table.hpp"

#include <algorithm>

namespace tandem::runtime {
namespace {

bool is_cancelable(GoalStatus status) {
  return status == GoalStatus::kAccepted || status == GoalStatus::kExecuting;
}

}  // namespace

bool GoalTable::accept(const GoalId& id, std::int64_t stamp) {
  if (goals_.size() >= kMaxGoals || find(id) != nullptr) return false;
  goals_.push_back({id, stamp});
  return true;
}

bool GoalTable::execute(const GoalId& id) {
  TrackedGoal* goal = find(id);
  if (goal == nullptr || goal->status != GoalStatus::kAccepted) return false;
  goal->status = GoalStatus::kExecuting;
  return true;
}

bool GoalTable::start_canceling(const GoalId& id) {
  TrackedGoal* goal = find(id);
  if (goal == nullptr || !is_cancelable(goal->status)) return false;
  goal->status = GoalStatus::kCanceling;
  return true;
}

bool GoalTable::finish(const GoalId& id, GoalStatus status, double now) {
  TrackedGoal* goal = find(id);
  if (goal == nullptr || has_ended(goal->status) || !has_ended(status)) return false;
  if (status == GoalStatus::kCanceled && goal->status != GoalStatus::kCanceling) return false;
  goal->status = status;
  goal->ended = now;
  return true;
}

GoalStatus GoalTable::status(const GoalId& id) const {
  const auto found = std::find_if(goals_.begin(), goals_.end(),
                                  [&](const TrackedGoal& goal) { return goal.id == id; });
  return found == goals_.end() ? GoalStatus::kUnknown : found->status;
}

GoalTable::Selection GoalTable::to_cancel(const GoalId& id, std::int64_t stamp) const {
  const bool has_id = id != GoalId{}, has_stamp = stamp != 0;
  Selection selection;
  for (const TrackedGoal& goal : goals_) {
    const bool is_meant =
        (!has_id && !has_stamp) || (has_id && goal.id == id) || (has_stamp && goal.stamp <= stamp);
    if (is_meant && is_cancelable(goal.status)) selection.goals.push_back(goal);
  }
  if (has_id && !has_stamp && selection.goals.empty())
    selection.answer =
        status(id) == GoalStatus::kUnknown ? CancelAnswer::kUnknown : CancelAnswer::kTerminated;
  return selection;
}

std::vector<GoalId> GoalTable::expire(double now) {
  std::vector<GoalId> expired;
  if (result_timeout_ < 0.0) return expired;
  std::erase_if(goals_, [&](const TrackedGoal& goal) {
    const bool is_over = has_ended(goal.status) && now - goal.ended > result_timeout_;
    if (is_over) expired.push_back(goal.id);
    return is_over;
  });
  return expired;
}

TrackedGoal* GoalTable::find(const GoalId& id) {
  const auto found = std::find_if(goals_.begin(), goals_.end(),
                                  [&](const TrackedGoal& goal) { return goal.id == id; });
  return found == goals_.end() ? nullptr : &*found;
}

}  // namespace tandem::runtime
