// SPDX-License-Identifier: Apache-2.0
// In: web clients' questions about parameters, "/node.name". Out: calls of the nodes' parameter
// services, and what they say.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tandem/dashboard/web/foxglove_protocol.hpp"
#include "tandem/dashboard/web/web_server.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

class ParameterRelay {
 public:
  static constexpr std::size_t kMaxNames = 1000;  // of one request, and that a client watches

  ParameterRelay(rt::Node& node, WebServer& web);

  /// The domain may have changed since the last beat. It is looked at once in a beat at most.
  void begin_beat() { nodes_.reset(); }
  /// Answers once all nodes have, or have had their time.
  void get(ClientId client, const foxglove::GetParameters& request);
  /// Says why not, and then what the values are.
  void set(ClientId client, const foxglove::SetParameters& request);
  void subscribe(ClientId client, const foxglove::SubscribeParameters& request);
  void forget(ClientId client) { wanted_.erase(client); }

 private:
  using Names = std::vector<std::string>;
  struct Clients {
    rt::Client<rcl_interfaces::srv::ListParameters> list;
    rt::Client<rcl_interfaces::srv::GetParameters> get;
    rt::Client<rcl_interfaces::srv::SetParameters> set;
  };
  // Goes to the client when the last question that shares it is answered.
  class Answer;

  [[nodiscard]] Clients* clients_of(const std::string& node);
  [[nodiscard]] const std::set<std::string>& nodes();
  [[nodiscard]] bool too_many(ClientId client, std::size_t names);
  void get(const std::string& node, const Names& names, const std::shared_ptr<Answer>& answer);
  void set(const std::string& node, const rcl_interfaces::srv::SetParameters_Request& wanted,
           const std::shared_ptr<Answer>& answer);
  void list(const std::string& node, const std::shared_ptr<Answer>& answer);
  void on_event(const rcl_interfaces::msg::ParameterEvent& event);

  rt::Node& node_;
  WebServer& web_;
  std::map<std::string, Clients> clients_;      // by node
  std::optional<std::set<std::string>> nodes_;  // with parameters, as of this beat
  std::map<ClientId, std::set<std::string>> wanted_;
  rt::Subscription events_;
};

}  // namespace tandem
