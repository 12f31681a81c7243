// SPDX-License-Identifier: Apache-2.0
// Sends goals to an action server and follows them until they end.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "tandem/runtime/action.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem::runtime {

/// What became of a goal that was sent.
enum class GoalReply {
  kAccepted,  ///< the server works on it
  kRejected,  ///< the server does not
  kNoAnswer,  ///< no answer in time; the goal is cancelled in case the server accepted it
};

/// What a client is told about a goal. Called on the node's thread; each may be empty.
template <class A>
struct GoalEvents {
  std::function<void(GoalReply)> on_reply{};                       ///< once
  std::function<void(const typename A::Feedback&)> on_feedback{};  ///< while it is active
  /// Once, after it was accepted. kUnknown, with an empty result: the server left (one that died
  /// leaves when DDS notices), or forgot the goal.
  std::function<void(GoalStatus, const typename A::Result&)> on_result{};
};

/// An action client's goals. Belongs to ActionClient.
template <class A>
class ActionClientState : public std::enable_shared_from_this<ActionClientState<A>> {
 public:
  using SendGoal = typename A::SendGoal;    ///< carries a goal
  using GetResult = typename A::GetResult;  ///< carries a result

  /// `action`: its full name.
  ActionClientState(Node& node, const std::string& action)
      : node_{node},
        parts_{parts_of(action)},
        send_goal_{node.create_client(ServiceName<SendGoal>{parts_.send_goal.c_str()})},
        cancel_{node.create_client(
            ServiceName<action_msgs::srv::CancelGoal>{parts_.cancel_goal.c_str()})},
        get_result_{node.create_client(ServiceName<GetResult>{parts_.get_result.c_str()})},
        feedback_{
            node.create_subscription(Topic<typename A::FeedbackMessage>{parts_.feedback.c_str()},
                                     [this](const auto& message) { on_feedback(message); })},
        status_{node.create_subscription(
            Topic<action_msgs::msg::GoalStatusArray>{parts_.status.c_str(), kActionStatus},
            [this](const auto& message) { on_status(message); })},
        watch_{node.create_wall_timer(kWatchPeriod, [this] { watch(); })} {}

  /// Whether a server was found.
  [[nodiscard]] bool ready() const {
    return send_goal_.ready() && cancel_.ready() && get_result_.ready();
  }

  /// See ActionClient::send().
  GoalId send(const typename A::Goal& goal, GoalEvents<A> events, double timeout) {
    const GoalId id = make_goal_id();
    goals_[id].events = std::move(events);
    typename SendGoal::Request request;
    request.goal_id(to_msg(id));
    request.goal(goal);
    const auto weak = this->weak_from_this();
    send_goal_.call(
        request,
        [weak, id](const auto& response) {
          if (const auto self = weak.lock())
            self->on_reply(id, response.accepted() ? GoalReply::kAccepted : GoalReply::kRejected);
        },
        timeout,
        [weak, id] {
          if (const auto self = weak.lock()) self->on_reply(id, GoalReply::kNoAnswer);
        });
    return id;
  }

  /// See ActionClient::cancel().
  void cancel(const GoalId& id, std::function<void(CancelAnswer)> fn, double timeout) {
    action_msgs::srv::CancelGoal_Request request;
    request.goal_info().goal_id(to_msg(id));
    cancel_.call(
        request,
        [fn](const auto& response) {
          if (fn) fn(static_cast<CancelAnswer>(response.return_code()));
        },
        timeout);
  }

  /// See ActionClient::status().
  [[nodiscard]] GoalStatus status(const GoalId& id) const {
    const auto found = goals_.find(id);
    return found == goals_.end() ? GoalStatus::kUnknown : found->second.status;
  }

 private:
  static constexpr double kWatchPeriod = 0.5;  // [s] between looks whether the server is there
  static constexpr double kNeverLate = 1e9;    // [s] a goal takes as long as it takes

  struct Sent {
    GoalEvents<A> events;
    bool is_accepted = false;
    GoalStatus status = GoalStatus::kUnknown;
    PublisherId server{};  // that published its status; zeros until it did
  };

  void on_reply(const GoalId& id, GoalReply reply) {
    const auto found = goals_.find(id);
    if (found == goals_.end()) return;
    found->second.is_accepted = reply == GoalReply::kAccepted;
    if (found->second.status == GoalStatus::kUnknown) found->second.status = GoalStatus::kAccepted;
    const auto fn = found->second.events.on_reply;
    if (reply == GoalReply::kAccepted)
      ask_result(id);
    else
      goals_.erase(found);
    if (reply == GoalReply::kNoAnswer) cancel(id, {}, Client<SendGoal>::kTimeout);
    if (fn) fn(reply);
  }

  void ask_result(const GoalId& id) {
    typename GetResult::Request request;
    request.goal_id(to_msg(id));
    get_result_.call(
        request,
        [weak = this->weak_from_this(), id](const auto& response) {
          if (const auto self = weak.lock())
            self->end(id, static_cast<GoalStatus>(response.status()), response.result());
        },
        kNeverLate);
  }

  void on_feedback(const typename A::FeedbackMessage& message) {
    const auto found = goals_.find(message.goal_id().uuid());
    if (found == goals_.end()) return;
    const auto alive = this->shared_from_this();  // the function may destroy the client
    const auto fn = found->second.events.on_feedback;
    if (fn) fn(message.feedback());
  }

  void on_status(const action_msgs::msg::GoalStatusArray& message) {
    for (const auto& each : message.status_list()) {
      const auto found = goals_.find(each.goal_info().goal_id().uuid());
      if (found == goals_.end()) continue;
      found->second.status = static_cast<GoalStatus>(each.status());
      found->second.server = status_.sender();
    }
  }

  // A server may be replaced by another of the same name, which does not know the goal.
  void watch() {
    const auto alive = this->shared_from_this();  // a function may destroy the client
    lose([this](const Sent& goal) {
      return goal.server == PublisherId{} ? !send_goal_.ready() : !node_.is_present(goal.server);
    });
  }

  // Ends the accepted goals that meet the condition, and drops the requests that wait for results.
  template <class Condition>
  void lose(Condition is_lost) {
    std::map<GoalId, Sent> lost;
    std::erase_if(goals_, [&](auto& entry) {
      const bool is_over = entry.second.is_accepted && is_lost(entry.second);
      if (is_over) lost.insert(std::move(entry));
      return is_over;
    });
    if (lost.empty()) return;
    get_result_ = node_.create_client(ServiceName<GetResult>{parts_.get_result.c_str()});
    for (const auto& [id, goal] : goals_)
      if (goal.is_accepted) ask_result(id);
    for (const auto& [id, goal] : lost)
      if (goal.events.on_result) goal.events.on_result(GoalStatus::kUnknown, {});
  }

  void end(const GoalId& id, GoalStatus status, const typename A::Result& result) {
    auto goal = goals_.extract(id);
    if (!goal.empty() && goal.mapped().events.on_result)
      goal.mapped().events.on_result(status, result);
  }

  Node& node_;
  ActionParts parts_;
  std::map<GoalId, Sent> goals_;
  Client<SendGoal> send_goal_;
  Client<action_msgs::srv::CancelGoal> cancel_;
  Client<GetResult> get_result_;
  Subscription feedback_, status_;
  Timer watch_;
};

/// Sends goals to an action's server until it is destroyed, which must be before its node is. Goals
/// go on without their client. Use on the node's thread.
template <class A>
class ActionClient {
 public:
  static constexpr double kTimeout = 2.0;  ///< [s]

  ActionClient() = default;
  /// Made by Node::create_action_client().
  explicit ActionClient(std::shared_ptr<ActionClientState<A>> state) : state_{std::move(state)} {}

  /// Whether a server was found.
  [[nodiscard]] bool ready() const { return state_->ready(); }

  /// Sends a goal and returns its id. `timeout` [s] of steady time covers finding a server and its
  /// answer.
  GoalId send(const typename A::Goal& goal, GoalEvents<A> events, double timeout = kTimeout) {
    return state_->send(goal, std::move(events), timeout);
  }

  /// Asks the server to cancel a goal. Its end is told by GoalEvents::on_result. `fn`, which may be
  /// empty, receives the answer.
  void cancel(const GoalId& id, std::function<void(CancelAnswer)> fn = {},
              double timeout = kTimeout) {
    state_->cancel(id, std::move(fn), timeout);
  }
  /// Asks the server to cancel all its goals, those of other clients too.
  void cancel_all(std::function<void(CancelAnswer)> fn = {}, double timeout = kTimeout) {
    state_->cancel({}, std::move(fn), timeout);
  }

  /// The status of a goal that has not ended, as the server published it last; else kUnknown.
  [[nodiscard]] GoalStatus status(const GoalId& id) const { return state_->status(id); }

 private:
  std::shared_ptr<ActionClientState<A>> state_;
};

template <class A>
ActionClient<A> Node::create_action_client(const ActionName<A>& action) {
  return ActionClient<A>{std::make_shared<ActionClientState<A>>(*this, resolve(action.name))};
}

}  // namespace tandem::runtime
