// SPDX-License-Identifier: Apache-2.0
// In: connections that come and go. Out: which of them has to make room.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace tandem {

/// Connections that have not become a WebSocket yet: all that a stranger without the token can
/// have. A new one always gets in, so that it can show a token; one that has waited makes room for
/// it. The clients inside are not counted here and cannot be displaced.
class ConnectionPool {
 public:
  using Id = std::uint64_t;
  struct Limits {
    std::size_t all = 64;
    std::size_t per_address = 24;
  };

  explicit ConnectionPool(Limits limits) : limits_{limits} {}

  /// A connection from an address; empty: it comes from a proxy, and the address is not known yet.
  [[nodiscard]] Id admit(const std::string& address);
  /// The address behind the proxy, from the request.
  void set_address(Id connection, const std::string& address);
  /// It is a client now, or it is closed.
  void remove(Id connection) { waiting_.erase(connection); }

  /// Takes out and returns the connection that has to be closed now, if any: the oldest of an
  /// address that has more than its limit, or of those with the most when all places are taken.
  [[nodiscard]] std::optional<Id> evict();

  [[nodiscard]] std::size_t size() const { return waiting_.size(); }

 private:
  Limits limits_;
  Id last_ = 0;
  std::map<Id, std::string> waiting_;  // the oldest first
};

}  // namespace tandem
