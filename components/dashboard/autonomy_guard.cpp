// SPDX-License-Identifier: Apache-2.0
#include "dashboard/autonomy_guard.hpp"

#include "topics.hpp"

namespace tandem {
namespace {

constexpr const char* kService = "arbitration/set_policy";

}  // namespace

AutonomyGuard::AutonomyGuard(rt::Node& node)
    : node_{node},
      set_policy_{node.create_client(rt::ServiceName<tandem_msgs::srv::SetPolicy>{kService})},
      on_status_{node.create_subscription(topics::arbitration_status,
                                          [this](const auto& msg) { on_policy(msg.policy()); })} {}

void AutonomyGuard::on_call(ClientId client, const std::string& name,
                            const std::vector<std::uint8_t>& request) {
  if (!name.ends_with(std::string{"/"} + kService)) return;
  const auto wanted = rt::decode<tandem_msgs::srv::SetPolicy::Request>(request);
  if (!wanted) return;
  in_force_ = false;
  if (wanted->policy() == kAutonomous)
    responsible_ = client;
  else
    responsible_.reset();
}

// A status that was under way before the call ends nobody's responsibility.
void AutonomyGuard::on_policy(const std::string& policy) {
  if (policy == kAutonomous)
    in_force_ = true;
  else if (in_force_)
    responsible_.reset();
}

void AutonomyGuard::on_leave(ClientId client) {
  if (responsible_ != client) return;
  responsible_.reset();
  node_.log().warn("web client {}, who let the robot drive by itself, is gone: policy shared",
                   client);
  tandem_msgs::srv::SetPolicy::Request request;
  request.policy("shared");
  set_policy_.call(request, [](const auto&) {});
}

}  // namespace tandem
