// SPDX-License-Identifier: Apache-2.0
// In: what web clients say and do, as it comes. Out: the same in the order in which it is worked
// off.
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

/// What a WebSocket client did.
struct WebEvent {
  enum class Kind { kJoined, kText, kBinary, kLeft };
  ClientId client;
  Kind kind;
  std::string bytes;
};

/// The events of one beat are taken lane by lane in this order.
enum class Lane {
  kUrgent,     ///< frames that were marked urgent: the emergency stop; clients take turns
  kLastWords,  ///< other frames of clients that have left
  kLeft,       ///< departures
  kJoined,     ///< arrivals
  kUsual       ///< all other frames, of the client first that has the most work left
};

/// A bounded queue for each client: what one of them sends delays and displaces nobody else's.
class ClientQueues {
 public:
  struct Limits {
    std::size_t frames = 1000;
    std::size_t bytes = 1 << 20;
    std::size_t urgent = 16;  ///< frames; one that repeats the frame before it is left out
  };

  explicit ClientQueues(Limits limits) : limits_{limits} {}

  void join(ClientId client, double now);
  /// False: its queue is full, and the frame is not taken.
  [[nodiscard]] bool push(WebEvent frame);
  void leave(ClientId client);

  /// Binary frames of the client that begin with one of these bytes are urgent from now on, those
  /// that wait included.
  void set_urgent(ClientId client, std::vector<std::string> prefixes);

  /// The next event of a lane; nothing: there is none, or nobody in it has work left.
  [[nodiscard]] std::optional<WebEvent> next(Lane lane, double now);
  /// Work [s] that an event of the client has cost.
  void charge(ClientId client, double work, double now);

 private:
  struct Client {
    explicit Client(double now) : budget{now} {}

    std::deque<WebEvent> urgent{}, usual{};
    std::size_t bytes = 0;  // of the usual ones
    std::vector<std::string> prefixes{};
    ClientBudget budget;
    bool announced = false;  // its arrival was taken
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
  ClientId last_urgent_ = 0;  // whose turn it was
};

}  // namespace tandem
