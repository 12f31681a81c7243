// SPDX-License-Identifier: Apache-2.0
// What servers and clients of actions share: an action's name, its topics and services, and the
// states of a goal. As rcl_action and action_msgs define them.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <msgs.hpp>

#include "tandem/runtime/qos.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// An action: its name (ROS 2 form) and its type A with A::Goal, A::Result and A::Feedback.
template <class A>
struct ActionName {
  const char* name;  ///< relative to the node's namespace, unless it begins with / or ~
};

/// A goal's id, a random UUID that the client chooses.
using GoalId = std::array<std::uint8_t, 16>;

/// A goal's state, with the numbers of action_msgs/msg/GoalStatus.
enum class GoalStatus : std::int8_t {
  kUnknown = 0,    ///< the server does not know the goal, or is gone
  kAccepted = 1,   ///< accepted, not begun
  kExecuting = 2,  ///< being worked on
  kCanceling = 3,  ///< being cancelled
  kSucceeded = 4,  ///< ended as wanted
  kCanceled = 5,   ///< ended because a client asked for it
  kAborted = 6,    ///< ended by the server
};

/// What a server answers to a request to cancel, with the numbers of action_msgs/srv/CancelGoal.
enum class CancelAnswer : std::int8_t {
  kNone = 0,        ///< no error: the goals are being cancelled
  kRejected = 1,    ///< the server goes on with all of them
  kUnknown = 2,     ///< there is no such goal
  kTerminated = 3,  ///< the goal has ended already
};

/// The status in one word: "executing".
[[nodiscard]] TANDEM_EXPORT const char* name(GoalStatus status);
/// Whether the goal has ended.
[[nodiscard]] constexpr bool has_ended(GoalStatus status) {
  return status >= GoalStatus::kSucceeded;
}

/// A new random id.
[[nodiscard]] TANDEM_EXPORT GoalId make_goal_id();
/// The id as hexadecimal digits in the groups of a UUID.
[[nodiscard]] TANDEM_EXPORT std::string to_text(const GoalId& id);
/// The id as a message.
[[nodiscard]] TANDEM_EXPORT unique_identifier_msgs::msg::UUID to_msg(const GoalId& id);

/// The names of an action's topics and services. ROS 2's tools hide them, as all names with a part
/// that begins with an underscore.
struct ActionParts {
  std::string send_goal, cancel_goal, get_result;  ///< services
  std::string feedback, status;                    ///< topics
};

/// The parts of the action of that name: "/a" has "/a/_action/send_goal".
[[nodiscard]] TANDEM_EXPORT ActionParts parts_of(const std::string& action);

/// How long a server returns the result of a goal that has ended [s], as rclcpp.
inline constexpr double kResultTimeout = 10.0;
/// QoS of an action's status: late clients get the last one.
inline constexpr QoS kActionStatus = kLatched;

}  // namespace tandem::runtime
