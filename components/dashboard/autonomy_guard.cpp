// SPDX-License-Identifier: Apache-2.0
#include "dashboard/autonomy_guard.hpp"

#include "topics.hpp"

namespace tandem {
namespace {

constexpr const char* kService = "arbitration/set_policy";

}  // namespace

AutonomyGuard::AutonomyGuard(rt::Node& node)
    : node_{node},
      set_policy_{node.create_client(rt::ServiceName<tandem_msgs::srv::SetPolicy>{kService})} {}

void AutonomyGuard::on_call(ClientId client, const std::string& name,
                            const std::vector<std::uint8_t>& request) {
  if (!name.ends_with(std::string{"/"} + kService)) return;
  const auto wanted = rt::decode<tandem_msgs::srv::SetPolicy::Request>(request);
  if (!wanted) return;
  if (wanted->policy() == "autonomous")
    responsible_ = client;
  else
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
