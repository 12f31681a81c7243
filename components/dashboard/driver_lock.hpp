// SPDX-License-Identifier: Apache-2.0
// The driver lock: decides which web client may drive.
#pragma once

#include <cstdint>
#include <optional>

namespace tandem {

using ClientId = std::uint64_t;

/// The lock of the driver, held by one client at a time. A free lock goes to the first client that
/// drives; a driver who has been silent for `timeout` [s] loses it. A driver who was preempted and
/// still holds their stick does not regain the lock by waiting. Times are seconds on one monotonic
/// clock.
class DriverLock {
 public:
  explicit DriverLock(double timeout) : timeout_{timeout} {}

  /// Whether the client may drive now; if so, it holds the lock from now on.
  [[nodiscard]] bool drive(ClientId client, double now) {
    if (still_preempted(client, now) || !may_write(client, now)) return false;
    take(client, now);
    return true;
  }
  /// Takes the lock, also from another client.
  void take(ClientId client, double now) {
    if (const auto before = driver(now); before && *before != client) preempted_ = {before, now};
    if (preempted_.client == client) preempted_ = {};
    driver_ = client;
    last_ = now;
  }
  /// Whether the client may make changes: no other client holds the lock.
  [[nodiscard]] bool may_write(ClientId client, double now) const {
    const auto other = driver(now);
    return !other || *other == client;
  }
  void leave(ClientId client) {
    if (driver_ == client) driver_.reset();
  }
  [[nodiscard]] std::optional<ClientId> driver(double now) const {
    return now - last_ <= timeout_ ? driver_ : std::nullopt;
  }

 private:
  struct Preempted {
    std::optional<ClientId> client;
    double tried = 0.0;  // time of its last attempt to drive
  };

  bool still_preempted(ClientId client, double now) {
    if (preempted_.client != client) return false;
    const bool holds = now - preempted_.tried <= timeout_;
    preempted_.tried = now;
    return holds;
  }

  Preempted preempted_;
  double timeout_, last_ = 0.0;
  std::optional<ClientId> driver_;
};

}  // namespace tandem
