// SPDX-License-Identifier: Apache-2.0
// Queues web clients' events and decides the order in which they are handled.
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/dashboard/driver_lock.hpp"
#include "tandem/dashboard/web/client_budget.hpp"

namespace tandem {

/// An event of a WebSocket client.
struct WebEvent {
  enum class Kind { kJoined, kText, kBinary, kLeft };
  ClientId client;
  Kind kind;
  std::string bytes;
};

/// The events of one tick are handled lane by lane, in this order.
enum class Lane {
  kUrgent,     ///< frames marked urgent (the emergency stop); clients take turns
  kLastWords,  ///< other frames of disconnected clients
  kLeft,       ///< disconnects
  kJoined,     ///< connects
  kUsual       ///< all other frames; the client with the largest budget first
};

/// A bounded queue for each client, so that no client can delay or displace the messages of
/// another.
class ClientQueues {
 public:
  struct Limits {
    std::size_t frames = 1000;
    std::size_t bytes = 1 << 20;
    std::size_t urgent = 16;  ///< frames; a repetition of the previous frame is dropped
  };

  explicit ClientQueues(Limits limits) : limits_{limits} {}

  void join(ClientId client, double now);
  /// Returns false if the client's queue is full; the frame is dropped.
  [[nodiscard]] bool push(WebEvent frame);
  void leave(ClientId client);

  /// From now on binary frames of the client with one of these prefixes are urgent, including those
  /// already queued.
  void set_urgent(ClientId client, std::vector<std::string> prefixes);

  /// The next event of a lane; nullopt if there is none or its clients have no budget left.
  [[nodiscard]] std::optional<WebEvent> next(Lane lane, double now);
  /// Charges the client for the work [s] that an event has caused.
  void charge(ClientId client, double work, double now);

 private:
  struct Client {
    explicit Client(double now) : budget{now} {}

    std::deque<WebEvent> urgent{}, usual{};
    std::size_t bytes = 0;  // of the usual frames
    std::vector<std::string> prefixes{};
    ClientBudget budget;
    bool announced = false;  // its connect event was handled
    bool left = false;
  };
  using Clients = std::map<ClientId, Client>;

  [[nodiscard]] bool push_urgent(Client& client, WebEvent frame) const;
  [[nodiscard]] std::optional<WebEvent> next_urgent();
  [[nodiscard]] std::optional<WebEvent> next_left();
  [[nodiscard]] std::optional<WebEvent> next_joined();
  [[nodiscard]] std::optional<WebEvent> next_usual(bool left, double now);

  Limits limits_;
  Clients clients_;
  ClientId last_urgent_ = 0;  // client served last
};

}  // namespace tandem
