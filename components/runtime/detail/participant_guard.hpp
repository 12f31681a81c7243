// SPDX-License-Identifier: Apache-2.0
// Filters the datagrams received by one participant. Private to runtime/.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "tandem/runtime/detail/reader_progress.hpp"
#include "tandem/runtime/detail/server_restarts.hpp"
#include "tandem/runtime/detail/wire_guard.hpp"

namespace tandem::runtime {

/// What the process's guard does for one transport; a participant has one, unless a profile names
/// several. Each participant has its own progress: readers of the same builtin topic have the same
/// entity id in all participants of a process.
/// `now`: [s], steady clock. Thread-safe.
class ParticipantGuard {
 public:
  /// `has_servers`: whether the participant is a client of discovery servers.
  ParticipantGuard(WireGuard& of_process, bool has_servers)
      : process_{of_process}, has_servers_{has_servers} {}

  /// If the datagram shows that its sender, a discovery server, has been started again: the goodbye
  /// of the one before, to be handed to the participant first. Otherwise empty. To be called before
  /// admits(), with the same datagram. `from`: its source address and port.
  [[nodiscard]] std::vector<std::uint8_t> goodbye_before(std::span<std::uint8_t> datagram,
                                                         std::uint64_t from, double now);
  /// Whether to pass the datagram to Fast DDS. Removes submessages that would make Fast DDS keep
  /// too much. `source`: see WireGuard.
  [[nodiscard]] bool admits(std::span<std::uint8_t> datagram, std::uint32_t source, double now);
  /// Records a datagram sent by the participant.
  void sent(std::span<const std::uint8_t> datagram, double now);

 private:
  WireGuard& process_;
  const bool has_servers_;
  std::mutex mutex_;  // guards the members below
  ReaderProgress progress_;
  ServerRestarts servers_;
};

}  // namespace tandem::runtime
