// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/action.hpp"

#include <spdlog/fmt/fmt.h>

#include <random>

namespace tandem::runtime {

const char* name(GoalStatus status) {
  switch (status) {
    case GoalStatus::kUnknown:
      return "unknown";
    case GoalStatus::kAccepted:
      return "accepted";
    case GoalStatus::kExecuting:
      return "executing";
    case GoalStatus::kCanceling:
      return "canceling";
    case GoalStatus::kSucceeded:
      return "succeeded";
    case GoalStatus::kCanceled:
      return "canceled";
    case GoalStatus::kAborted:
      return "aborted";
  }
  return "?";
}

// RFC 9562, version 4.
GoalId make_goal_id() {
  std::random_device random;
  std::uniform_int_distribution<int> byte{0, 255};
  GoalId id{};
  for (auto& value : id) value = static_cast<std::uint8_t>(byte(random));
  id[6] = static_cast<std::uint8_t>((id[6] & 0x0f) | 0x40);
  id[8] = static_cast<std::uint8_t>((id[8] & 0x3f) | 0x80);
  return id;
}

std::string to_text(const GoalId& id) {
  std::string text;
  for (std::size_t i = 0; i < id.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += fmt::format("{:02x}", id[i]);
  }
  return text;
}

unique_identifier_msgs::msg::UUID to_msg(const GoalId& id) {
  unique_identifier_msgs::msg::UUID msg;
  msg.uuid(id);
  return msg;
}

ActionParts parts_of(const std::string& action) {
  const std::string prefix = action + "/_action/";
  return {prefix + "send_goal", prefix + "cancel_goal", prefix + "get_result", prefix + "feedback",
          prefix + "status"};
}

}  // namespace tandem::runtime
