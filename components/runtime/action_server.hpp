// SPDX-License-Identifier: Apache-2.0
// Serves an action: accepts goals, publishes their feedback, and returns their results.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tandem/runtime/goal_table.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// What a server does with a new goal.
enum class GoalAnswer {
  kReject,   ///< it is not accepted
  kExecute,  ///< it is accepted, and executing at once
  kDefer,    ///< it is accepted, and executing from ServerGoal::execute() on
};

/// The untyped part of an action server: the states of its goals, their publication, requests to
/// cancel, and the time after which results are forgotten.
class TANDEM_EXPORT ServedGoals {
 public:
  /// What depends on the action's type.
  struct Hooks {
    std::function<bool(const GoalId&)> may_cancel;  ///< whether the goal may be cancelled
    std::function<void(const GoalId&)> on_expired;  ///< the goal is forgotten
  };

  /// `action`: its full name. `result_timeout`: [s], see GoalTable.
  ServedGoals(Node& node, const std::string& action, double result_timeout, Hooks hooks);

  /// Adds a goal and returns the time of its acceptance; nullopt for one that cannot be added.
  std::optional<builtin_interfaces::msg::Time> accept(const GoalId& id);
  /// As GoalTable::execute(), and publishes the new status.
  void execute(const GoalId& id);
  /// As GoalTable::finish(), and publishes the new status; logs an error for a transition that does
  /// not exist.
  bool finish(const GoalId& id, GoalStatus status);
  /// Publishes the status of all goals.
  void publish() const;
  /// The goal's state.
  [[nodiscard]] GoalStatus status(const GoalId& id) const { return table_.status(id); }
  /// As Node::is_present().
  [[nodiscard]] bool is_present(const PublisherId& client) const {
    return node_.is_present(client);
  }
  /// Whether the goal was accepted and is not forgotten.
  [[nodiscard]] bool knows(const GoalId& id) const { return status(id) != GoalStatus::kUnknown; }

 private:
  void cancel(const action_msgs::srv::CancelGoal_Request& request,
              action_msgs::srv::CancelGoal_Response& response);
  void expire();

  Node& node_;
  std::string action_;
  Hooks hooks_;
  GoalTable table_;
  Publisher<action_msgs::msg::GoalStatusArray> status_;
  Service cancel_;
  Timer expiry_;
};

template <class A>
class ServerGoal;

/// What a component does with the goals of an action. Called on the node's thread; none may destroy
/// the server.
template <class A>
struct ActionHandlers {
  /// Decides on a new goal.
  std::function<GoalAnswer(const typename A::Goal&)> on_goal;
  /// Decides on a request to cancel. After `true` the goal is_canceling(), and the component ends
  /// it soon, usually with canceled().
  std::function<bool(const ServerGoal<A>&)> on_cancel;
  /// Receives an accepted goal, which the component ends by one of the functions of ServerGoal.
  std::function<void(ServerGoal<A>)> on_accepted;
};

/// An action server's goals with their messages. Belongs to ActionServer and ServerGoal.
template <class A>
class ActionServerState : public std::enable_shared_from_this<ActionServerState<A>> {
 public:
  using Goal = typename A::Goal;          ///< what is asked for
  using Result = typename A::Result;      ///< what came of it
  using Feedback = typename A::Feedback;  ///< how it goes on

  /// `action`: its full name.
  ActionServerState(Node& node, const std::string& action, ActionHandlers<A> handlers,
                    double result_timeout)
      : handlers_{std::move(handlers)},
        goals_{node,
               action,
               result_timeout,
               {.may_cancel = [this](const GoalId& id) { return may_cancel(id); },
                .on_expired = [this](const GoalId& id) { kept_.erase(id); }}},
        feedback_{node.create_publisher(
            Topic<typename A::FeedbackMessage>{parts_of(action).feedback.c_str()})},
        send_goal_{node.create_deferred_service(
            ServiceName<typename A::SendGoal>{parts_of(action).send_goal.c_str()},
            [this](const auto& request, auto reply) { on_goal(request, reply); })},
        get_result_{node.create_deferred_service(
            ServiceName<typename A::GetResult>{parts_of(action).get_result.c_str()},
            [this](const auto& request, auto reply) { on_get_result(request, reply); })} {}

  /// The state of all goals.
  [[nodiscard]] ServedGoals& goals() { return goals_; }
  /// Publishes feedback of an active goal.
  void publish(const GoalId& id, const Feedback& feedback) const {
    if (!goals_.knows(id) || has_ended(goals_.status(id))) return;
    typename A::FeedbackMessage message;
    message.goal_id(to_msg(id));
    message.feedback(feedback);
    feedback_.publish(message);
  }
  /// Whether the client that sent the goal is on the domain.
  [[nodiscard]] bool has_client(const GoalId& id) const {
    const auto found = kept_.find(id);
    return found != kept_.end() && goals_.is_present(found->second.client);
  }
  /// Ends a goal and answers the clients that wait for its result.
  void finish(const GoalId& id, GoalStatus status, const Result& result) {
    if (!goals_.finish(id, status)) return;
    Kept& kept = kept_[id];
    kept.response.status(static_cast<std::int8_t>(status));
    kept.response.result(result);
    for (const auto& reply : std::exchange(kept.waiting, {})) reply.send(kept.response);
  }

 private:
  static constexpr std::size_t kMaxWaiting = 100;  // requests for one result

  struct Kept {
    std::shared_ptr<const Goal> goal;
    PublisherId client{};
    typename A::GetResult::Response response;  // once it has ended
    std::vector<Reply<typename A::GetResult>> waiting;
  };

  ServerGoal<A> handle(const GoalId& id) { return {this->weak_from_this(), id, kept_.at(id).goal}; }
  bool may_cancel(const GoalId& id) {
    return handlers_.on_cancel && handlers_.on_cancel(handle(id));
  }

  void on_goal(const typename A::SendGoal::Request& request, Reply<typename A::SendGoal> reply) {
    const GoalId id = request.goal_id().uuid();
    typename A::SendGoal::Response response;
    const auto goal = std::make_shared<const Goal>(request.goal());
    const GoalAnswer answer = goals_.knows(id) ? GoalAnswer::kReject : handlers_.on_goal(*goal);
    const auto stamp = answer == GoalAnswer::kReject ? std::nullopt : goals_.accept(id);
    response.accepted(stamp.has_value());
    if (stamp) response.stamp(*stamp);
    reply.send(response);
    if (!stamp) return;
    kept_[id].goal = goal;
    kept_[id].client = reply.client();
    goals_.publish();
    if (answer == GoalAnswer::kExecute) goals_.execute(id);
    handlers_.on_accepted(handle(id));
  }

  void on_get_result(const typename A::GetResult::Request& request,
                     Reply<typename A::GetResult> reply) {
    const auto found = kept_.find(request.goal_id().uuid());
    if (found == kept_.end()) return reply.send({});  // its status is kUnknown
    Kept& kept = found->second;
    if (has_ended(goals_.status(found->first)))
      reply.send(kept.response);
    else if (kept.waiting.size() < kMaxWaiting)
      kept.waiting.push_back(std::move(reply));
  }

  ActionHandlers<A> handlers_;
  std::map<GoalId, Kept> kept_;
  ServedGoals goals_;
  Publisher<typename A::FeedbackMessage> feedback_;
  Service send_goal_, get_result_;
};

/// An accepted goal in the hands of the component that serves it. Copies are the same goal. Without
/// its server, and once the goal has ended, it does nothing. Use on the node's thread.
template <class A>
class ServerGoal {
 public:
  /// No goal.
  ServerGoal() = default;
  /// Made by ActionServer.
  ServerGoal(std::weak_ptr<ActionServerState<A>> server, const GoalId& id,
             std::shared_ptr<const typename A::Goal> goal)
      : server_{std::move(server)}, id_{id}, goal_{std::move(goal)} {}

  /// The id that the client chose.
  [[nodiscard]] const GoalId& id() const { return id_; }
  /// What the client asks for. Not to be called on a default-constructed one.
  [[nodiscard]] const typename A::Goal& goal() const { return *goal_; }
  /// Its state; kUnknown once it was forgotten.
  [[nodiscard]] GoalStatus status() const {
    const auto server = server_.lock();
    return server ? server->goals().status(id_) : GoalStatus::kUnknown;
  }
  /// Whether it has not ended.
  [[nodiscard]] bool is_active() const {
    return status() != GoalStatus::kUnknown && !has_ended(status());
  }
  /// Whether a client asked to cancel it, and the component agreed.
  [[nodiscard]] bool is_canceling() const { return status() == GoalStatus::kCanceling; }

  /// Whether the client that sent it is on the domain. One that died is until DDS notices.
  [[nodiscard]] bool has_client() const {
    const auto server = server_.lock();
    return server && server->has_client(id_);
  }

  /// Begins a goal that was accepted by kDefer.
  void execute() const {
    if (const auto server = server_.lock()) server->goals().execute(id_);
  }
  /// Publishes how it goes on.
  void publish_feedback(const typename A::Feedback& feedback) const {
    if (const auto server = server_.lock()) server->publish(id_, feedback);
  }
  /// Ends it: it was reached.
  void succeed(const typename A::Result& result) const { end(GoalStatus::kSucceeded, result); }
  /// Ends it: the server gives up.
  void abort(const typename A::Result& result) const { end(GoalStatus::kAborted, result); }
  /// Ends a goal that is_canceling().
  void canceled(const typename A::Result& result) const { end(GoalStatus::kCanceled, result); }

 private:
  void end(GoalStatus status, const typename A::Result& result) const {
    if (const auto server = server_.lock()) server->finish(id_, status, result);
  }

  std::weak_ptr<ActionServerState<A>> server_;
  GoalId id_{};
  std::shared_ptr<const typename A::Goal> goal_;
};

/// Serves an action until it is destroyed, which must be before its node is.
template <class A>
class ActionServer {
 public:
  ActionServer() = default;
  /// Made by Node::create_action_server().
  explicit ActionServer(std::shared_ptr<ActionServerState<A>> state) : state_{std::move(state)} {}

 private:
  std::shared_ptr<ActionServerState<A>> state_;
};

template <class A>
ActionServer<A> Node::create_action_server(const ActionName<A>& action, ActionHandlers<A> handlers,
                                           double result_timeout) {
  return ActionServer<A>{std::make_shared<ActionServerState<A>>(
      *this, resolve(action.name), std::move(handlers), result_timeout)};
}

}  // namespace tandem::runtime
