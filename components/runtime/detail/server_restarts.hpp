// SPDX-License-Identifier: Apache-2.0
// Notices that a discovery server has been started again. Private to runtime/.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "tandem/runtime/detail/rtps_edit.hpp"

namespace tandem::runtime {

/// Whether the prefix is of a server of ROS_DISCOVERY_SERVER. They differ in the server's number
/// only, so a server that is started again has the one that it had before.
[[nodiscard]] bool is_server(const GuidPrefix& prefix);

/// Watches what one participant receives from its discovery servers. Fast DDS takes a server that
/// has died and is back within its lease (20 s) for the one that it knows: it ignores what the new
/// one announces under numbers that it has seen, and does not announce its own endpoints again.
/// New participants and this one would never meet.
///
/// A server announces itself every 3 s, under the number and with the time that the announcement
/// had at first. Another time under the same number is that of a new server, and so is a first
/// announcement of itself from another port than what arrived before it: Fast DDS is then handed
/// the goodbye that the old one had no time to send. Until then, what the new server announces must
/// not be acknowledged. It sends from another port than the old one, so its announcements are
/// removed until the one of itself has come from there. Not thread-safe.
class ServerRestarts {
 public:
  /// [s]; several announcements of itself may be lost. After that the source counts as a second
  /// address of a live server.
  static constexpr double kLongestSuspicion = 15.0;
  /// [s] between two restarts: announcements can be forged, and each goodbye has Fast DDS match the
  /// server anew.
  static constexpr double kLeastLife = 1.0;

  /// Takes a valid datagram of a server; `from`: its source address and port; `now`: [s], steady
  /// clock. Removes announcements from a source from which the server has not announced itself.
  /// Returns whether the datagram shows that the server has been started again; the old one's
  /// goodbye must then be handled first.
  [[nodiscard]] bool are_shown_by(std::span<std::uint8_t> datagram, std::uint64_t from, double now);

 private:
  struct Server {
    std::int64_t number = 0;             // of its announcement of itself; 0: not heard
    std::uint64_t time = 0;              // of the same, as in the message
    std::optional<double> restarted;     // last time that it was [s]
    std::vector<std::uint64_t> sources;  // also those before its restarts
    std::optional<double> suspected;     // since when it has sent from other sources [s]

    /// Takes its announcement of itself. Returns whether it is a new server's.
    [[nodiscard]] bool restarts(std::int64_t announced, std::uint64_t at, std::uint64_t from,
                                double now);
    [[nodiscard]] bool suspects(std::uint64_t from, double now);
    [[nodiscard]] bool has(std::uint64_t source) const;
    void add(std::uint64_t source);
  };

  std::map<GuidPrefix, Server> servers_;
};

/// The datagram with which a server leaves: a HEARTBEAT by which readers wait for no announcement
/// before `number`, and its goodbye under that number.
[[nodiscard]] std::vector<std::uint8_t> goodbye_of(const GuidPrefix& server, std::int64_t number);

}  // namespace tandem::runtime
