// SPDX-License-Identifier: Apache-2.0
// In: what web clients call, and who of them goes. Out: the end of autonomy that nobody watches.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "tandem/dashboard/driver_lock.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Who lets the robot drive by itself has to stay: when the client that set arbitration's policy
/// `autonomous` is gone (page closed, network lost), the policy becomes `shared`, in which the
/// robot stands until somebody holds a stick. Not if another policy is in force by then. Each robot
/// of the domain for itself: a client may call any of them.
class AutonomyGuard {
 public:
  explicit AutonomyGuard(rt::Node& node) : node_{node} {}

  /// A client's call of the service `name`, its request in CDR.
  void on_call(ClientId client, const std::string& name, const std::vector<std::uint8_t>& request);
  void on_leave(ClientId client);

 private:
  struct Robot {
    rt::Client<tandem_msgs::srv::SetPolicy> set_policy = {};
    rt::Subscription on_status = {};
    std::optional<ClientId> responsible = {};
    bool in_force = false;  // it was heard that the policy is the client's
  };

  [[nodiscard]] Robot& robot_in(const std::string& space);

  rt::Node& node_;
  std::map<std::string, Robot> robots_;  // by namespace, "" or "/a"; those that somebody let drive
};

}  // namespace tandem
