// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/autonomy_guard.hpp"

#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

using tandem_msgs::srv::SetPolicy;

constexpr const char* kService = "/arbitration/set_policy";
constexpr const char* kAutonomous = "autonomous";

}  // namespace

void AutonomyGuard::on_call(ClientId client, const std::string& name,
                            const std::vector<std::uint8_t>& request) {
  if (!name.ends_with(kService)) return;
  const auto wanted = rt::decode<SetPolicy::Request>(request);
  if (!wanted) return;
  const std::string space = name.substr(0, name.size() - std::string{kService}.size());
  const bool autonomous = wanted->policy() == kAutonomous;
  if (!autonomous && !robots_.contains(space)) return;
  Robot& robot = robot_in(space);
  robot.in_force = false;
  robot.responsible = autonomous ? std::optional{client} : std::nullopt;
}

// A status counts only after `autonomous` was confirmed: an older one that is still in transit must
// not end the client's responsibility.
AutonomyGuard::Robot& AutonomyGuard::robot_in(const std::string& space) {
  const auto [it, is_new] = robots_.try_emplace(space);
  Robot& robot = it->second;
  if (!is_new) return robot;
  const std::string service = space + kService;
  const std::string status = space + "/" + topics::arbitration_status.name;
  robot.set_policy = node_.create_client(rt::ServiceName<SetPolicy>{service.c_str()});
  robot.on_status = node_.create_subscription(
      rt::Topic<tandem_msgs::msg::ArbitrationStatus>{status.c_str(),
                                                     topics::arbitration_status.qos},
      [&robot](const auto& msg) {
        if (msg.policy() == kAutonomous)
          robot.in_force = true;
        else if (robot.in_force)
          robot.responsible.reset();
      });
  return robot;
}

void AutonomyGuard::on_leave(ClientId client) {
  for (auto& [space, robot] : robots_) {
    if (robot.responsible != client) continue;
    robot.responsible.reset();
    node_.log().warn(
        "web client {} disconnected after starting autonomous driving of the robot in {}: policy "
        "set to shared",
        client, space + "/");
    SetPolicy::Request request;
    request.policy("shared");
    robot.set_policy.call(request, [](const auto&) {});
  }
}

}  // namespace tandem
