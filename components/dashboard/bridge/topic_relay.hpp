// SPDX-License-Identifier: Apache-2.0
// In: the domain's topics. Out: channels for web clients, CDR passed through untouched.
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

/// Offers each topic whose type the IDL knows as a channel, and listens to those that somebody
/// wants.
class TopicRelay {
 public:
  static constexpr std::size_t kMaxSubscriptions = 500;  // of one client, and of one request
  static constexpr int kMaxOfOne = 4;   // subscriptions of one client to one channel
  static constexpr double kRest = 5.0;  // [s] until a topic that nobody wants is not listened to

  /// `own`: channels that are no topics and that tell() fills; their ids are the first ones.
  TopicRelay(rt::Node& node, WebServer& web, std::vector<foxglove::Channel> own);

  /// Tells the clients which topics have come and gone.
  void look(const std::set<ClientId>& clients);
  void greet(ClientId client);
  void forget(ClientId client);
  /// A client may have several subscriptions of one channel: parts of a page do not know each
  /// other.
  void subscribe(ClientId client, const foxglove::Subscribe& request);
  void unsubscribe(ClientId client, const foxglove::Unsubscribe& request);
  /// Begins to listen to one of the topics that somebody wants.
  void listen_to_next();

  /// Sends a message of an own channel, to a client who listens to it.
  void tell(ClientId client, std::uint32_t channel, const std::string& payload);

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
    // Of a latched topic, for who comes later: each sender's last, as they came.
    std::vector<std::pair<rt::PublisherId, Body>> last;
  };

  [[nodiscard]] Relayed* find(std::uint32_t channel);
  [[nodiscard]] std::string subscribe(ClientId client, const foxglove::Subscribe::One& wanted);
  void unsubscribe(ClientId client, std::uint32_t subscription);
  void listen(Relayed& relayed);
  void relay(Relayed& relayed, const std::vector<std::uint8_t>& bytes);
  void send(const Listener& to, const Body& body);
  void rest();

  rt::Node& node_;
  WebServer& web_;
  std::map<std::pair<std::string, std::string>, Relayed> relayed_;       // by topic and type
  std::map<ClientId, std::map<std::uint32_t, std::uint32_t>> channels_;  // by subscription
  Body greeting_;  // all channels, until one comes or goes
  std::uint32_t last_id_ = 0;
};

}  // namespace tandem
