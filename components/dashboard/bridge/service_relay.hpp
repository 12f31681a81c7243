// SPDX-License-Identifier: Apache-2.0
// Relays web clients' service calls to the domain and returns the answers.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tandem/dashboard/web/foxglove_protocol.hpp"
#include "tandem/dashboard/web/web_server.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Offers each service whose type is in the IDL, except those that load code into a process.
class ServiceRelay {
 public:
  static constexpr double kTimeout = 5.0;  // [s]
  static constexpr int kMaxCalls = 10;     // pending calls per client

  /// `own`: name of a Trigger service that the dashboard itself provides to web clients only;
  /// `on_own` answers its calls.
  ServiceRelay(rt::Node& node, WebServer& web, const std::string& own,
               std::function<std_srvs::srv::Trigger::Response(ClientId)> on_own);

  void look(const std::set<ClientId>& clients);
  void announce_all(ClientId client);
  void forget(ClientId client) { waiting_.erase(client); }

  /// Whether the service with that id only reads, or is the own one: such services are open to
  /// clients that do not drive.
  [[nodiscard]] bool only_reads(std::uint32_t service) const;
  /// Name of the domain's service with that id; empty if there is none.
  [[nodiscard]] std::string name(std::uint32_t service) const;
  void call(ClientId client, const foxglove::ServiceCall& call);

 private:
  struct Relayed {
    foxglove::Service service;
    rt::GenericClient client;
    bool opened = false;
  };

  [[nodiscard]] Relayed* find(std::uint32_t service);
  [[nodiscard]] const Relayed* find(std::uint32_t service) const;
  void ask(ClientId client, const foxglove::ServiceCall& call, Relayed& relayed);
  void answer(ClientId client, const foxglove::ServiceCall& call,
              const std::vector<std::uint8_t>& bytes);
  void fail(ClientId client, const foxglove::ServiceCall& call, const std::string& why);

  rt::Node& node_;
  WebServer& web_;
  std::function<std_srvs::srv::Trigger::Response(ClientId)> on_own_;
  std::map<std::string, Relayed> relayed_;  // by name
  std::map<ClientId, int> waiting_;
  std::shared_ptr<const std::vector<std::uint8_t>>
      announcement_;  // cached until the services change
  std::uint32_t last_id_ = 1;
};

}  // namespace tandem
