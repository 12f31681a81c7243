// SPDX-License-Identifier: Apache-2.0
// Offers the domain's topics to web clients as channels; CDR payloads are passed through unchanged.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tandem/dashboard/web/foxglove_protocol.hpp"
#include "tandem/dashboard/web/web_server.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Offers each topic whose type is in the IDL as a channel, and subscribes to those that a client
/// requests.
class TopicRelay {
 public:
  static constexpr std::size_t kMaxSubscriptions = 500;  // limit per client and per request
  static constexpr int kMaxOfOne = 4;                    // limit per client and channel
  static constexpr double kRest = 5.0;  // [s] delay before an unused subscription is removed

  /// `own`: channels that are not topics and are filled by send_own(); they get the first ids.
  TopicRelay(rt::Node& node, WebServer& web, std::vector<foxglove::Channel> own);

  /// Announces topics that were added or removed to the clients.
  void look(const std::set<ClientId>& clients);
  void announce_all(ClientId client);
  void forget(ClientId client);
  /// A client may subscribe to a channel several times, because parts of a page work independently.
  void subscribe(ClientId client, const foxglove::Subscribe& request);
  void unsubscribe(ClientId client, const foxglove::Unsubscribe& request);
  /// Subscribes to one of the topics that clients are waiting for.
  void listen_to_next();
  /// Ends one of the subscriptions that no client has used for kRest; to be called regularly.
  void rest();

  /// Sends a message on an own channel, if the client subscribes to it.
  void send_own(ClientId client, std::uint32_t channel, const std::string& payload);

 private:
  using Body = std::shared_ptr<const std::vector<std::uint8_t>>;
  struct Listener {
    ClientId client;
    std::uint32_t subscription;
  };
  struct Relayed {
    foxglove::Channel channel;
    std::vector<rt::Policies> publishers;
    std::vector<Listener> listeners;
    rt::Subscription subscription;
    bool listening = false, latched = false;
    double unused_since = 0.0;  // [s]
    // Of a latched topic, for late joiners: each publisher's last message, in order of arrival.
    std::vector<std::pair<rt::PublisherId, Body>> last;
  };

  [[nodiscard]] Relayed* find(std::uint32_t channel);
  [[nodiscard]] std::string subscribe(ClientId client, const foxglove::Subscribe::One& wanted);
  void unsubscribe(ClientId client, std::uint32_t subscription);
  void listen(Relayed& relayed);
  void relay(Relayed& relayed, const std::vector<std::uint8_t>& bytes);
  void send(const Listener& to, const Body& body);

  rt::Node& node_;
  WebServer& web_;
  std::map<std::pair<std::string, std::string>, Relayed> relayed_;       // by topic and type
  std::map<ClientId, std::map<std::uint32_t, std::uint32_t>> channels_;  // by subscription
  Body announcement_;  // all channels; cached until they change
  std::uint32_t last_id_ = 0;
};

}  // namespace tandem
