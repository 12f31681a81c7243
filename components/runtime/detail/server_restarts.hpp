// SPDX-License-Identifier: Apache-2.0
// Notices that a discovery server has been started again. Private to runtime/.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "tandem/runtime/detail/rtps_edit.hpp"

namespace tandem::runtime {

/// Whether the prefix is of a server of ROS_DISCOVERY_SERVER. They differ in the server's number
/// only, so a server that is started again has the one that it had before.
[[nodiscard]] bool is_server(const GuidPrefix& prefix);

/// Watches what one participant exchanges with its discovery servers. Fast DDS takes a server that
/// has died and is back within its lease (20 s) for the one that it knows: it ignores what the new
/// one announces under numbers that it has seen, and does not announce its own endpoints again.
/// New participants and this one would never meet.
///
/// A writer's numbers only rise, so a server whose HEARTBEAT ends below what the participant has
/// acknowledged has begun anew. Not thread-safe.
class ServerRestarts {
 public:
  /// Records the acknowledgements in a datagram that the participant sends.
  void sent(std::span<const std::uint8_t> datagram);
  /// If a datagram that arrives shows that its server has been started again: the datagram with
  /// which the old one would have said goodbye, to be handled first. Otherwise empty.
  [[nodiscard]] std::vector<std::uint8_t> goodbye_before(std::span<const std::uint8_t> datagram);

 private:
  std::map<GuidPrefix, std::int64_t> next_;  // first announcement that is missing, by server
};

}  // namespace tandem::runtime
