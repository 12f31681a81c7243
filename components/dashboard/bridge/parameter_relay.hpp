// SPDX-License-Identifier: Apache-2.0
// Relays web clients' parameter requests ("/node.name") to the nodes' parameter services and
// returns the answers.
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
  static constexpr std::size_t kMaxNames = 1000;  // per request, and watched per client

  ParameterRelay(rt::Node& node, WebServer& web);

  /// Call at the start of a tick: drops the cached node list, which is read at most once per tick.
  void begin_beat() { nodes_.reset(); }
  /// Answers once all nodes have answered or timed out.
  void get(ClientId client, const foxglove::GetParameters& request);
  /// Sets parameters, reports failures, and then sends the resulting values.
  void set(ClientId client, const foxglove::SetParameters& request);
  void subscribe(ClientId client, const foxglove::SubscribeParameters& request);
  void forget(ClientId client);

 private:
  using Names = std::vector<std::string>;
  struct Clients {
    rt::Client<rcl_interfaces::srv::ListParameters> list;
    rt::Client<rcl_interfaces::srv::GetParameters> get;
    rt::Client<rcl_interfaces::srv::SetParameters> set;
  };
  // The shared answer to a client, sent when the last request that shares it completes.
  class Answer;

  [[nodiscard]] Clients* clients_of(const std::string& node);
  [[nodiscard]] const std::set<std::string>& nodes();
  [[nodiscard]] bool too_many(ClientId client, std::size_t names);
  void get(const std::string& node, const Names& names, const std::shared_ptr<Answer>& answer);
  void set(const std::string& node, const rcl_interfaces::srv::SetParameters_Request& wanted,
           const std::shared_ptr<Answer>& answer);
  void list(const std::string& node, const std::shared_ptr<Answer>& answer);
  void listen_if_wanted();
  void on_event(const rcl_interfaces::msg::ParameterEvent& event);

  rt::Node& node_;
  WebServer& web_;
  std::map<std::string, Clients> clients_;      // by node
  std::optional<std::set<std::string>> nodes_;  // nodes with parameters, as of this tick
  std::map<ClientId, std::set<std::string>> wanted_;
  std::optional<rt::Subscription> events_;  // while a client wants some
};

}  // namespace tandem
