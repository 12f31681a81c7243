// SPDX-License-Identifier: Apache-2.0
// Limits the connections of clients that have not authenticated yet.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace tandem {

/// Connections that are not WebSockets yet, which is all that a client without the token can have.
/// A new connection is always admitted, so that it can present a token; an older one is evicted for
/// it. Clients with a WebSocket are not counted here and cannot be evicted.
class ConnectionPool {
 public:
  using Id = std::uint64_t;
  struct Limits {
    std::size_t all = 64;
    std::size_t per_address = 24;
  };

  explicit ConnectionPool(Limits limits) : limits_{limits} {}

  /// Admits a connection from an address; empty: it comes from a proxy, and the address is not
  /// known yet.
  [[nodiscard]] Id admit(const std::string& address);
  /// Sets the address behind the proxy, taken from the request.
  void set_address(Id connection, const std::string& address);
  /// Call when the connection became a client or was closed.
  void remove(Id connection) { waiting_.erase(connection); }

  /// Removes and returns the connection that must be closed now, if any: the oldest of an address
  /// that exceeds its limit or, if all places are taken, of the address with the most connections.
  [[nodiscard]] std::optional<Id> evict();

  [[nodiscard]] std::size_t size() const { return waiting_.size(); }

 private:
  Limits limits_;
  Id last_ = 0;
  std::map<Id, std::string> waiting_;  // oldest first
};

}  // namespace tandem
