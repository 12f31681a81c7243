// SPDX-License-Identifier: Apache-2.0
// Ends autonomous driving when the web client that started it disconnects.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "tandem/dashboard/driver_lock.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// When the client that set arbitration's policy `autonomous` disconnects (page closed, network
/// lost), the policy is set to `shared`, in which the robot stands until somebody holds a stick.
/// Nothing happens if another policy is in force by then. Each robot of the domain is tracked
/// separately, because a client may call any of them.
class AutonomyGuard {
 public:
  explicit AutonomyGuard(rt::Node& node) : node_{node} {}

  /// Call for each service call of a client: `name` of the service, request in CDR.
  void on_call(ClientId client, const std::string& name, const std::vector<std::uint8_t>& request);
  void on_leave(ClientId client);

 private:
  struct Robot {
    rt::Client<tandem_msgs::srv::SetPolicy> set_policy = {};
    rt::Subscription on_status = {};
    std::optional<ClientId> responsible = {};
    bool in_force = false;  // a status has confirmed the client's policy
  };

  [[nodiscard]] Robot& robot_in(const std::string& space);

  rt::Node& node_;
  std::map<std::string, Robot> robots_;  // by namespace, "" or "/a"; only those set to `autonomous`
};

}  // namespace tandem
