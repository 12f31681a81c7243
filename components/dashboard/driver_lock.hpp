// SPDX-License-Identifier: Apache-2.0
// In: who wants to drive. Out: who may.
#pragma once

#include <cstdint>
#include <optional>

namespace tandem {

using ClientId = std::uint64_t;

/// The driver's seat: one at a time. A free seat belongs to the first who drives; a driver who has
/// been silent for `timeout` [s] has left it. Whom another has ousted, and who still holds their
/// stick, does not get it back by waiting. Times are seconds on one monotonic clock.
class DriverLock {
 public:
  explicit DriverLock(double timeout) : timeout_{timeout} {}

  /// Whether the client may drive now; then the seat is theirs.
  [[nodiscard]] bool drive(ClientId client, double now) {
    if (still_preempted(client, now) || !may_write(client, now)) return false;
    take(client, now);
    return true;
  }
  /// Takes the seat, also from another.
  void take(ClientId client, double now) {
    if (const auto before = driver(now); before && *before != client) preempted_ = {before, now};
    if (preempted_.client == client) preempted_ = {};
    driver_ = client;
    last_ = now;
  }
  /// Whether the client may change anything: nobody else sits there.
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
    double tried = 0.0;  // last, to drive
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
