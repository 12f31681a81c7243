// SPDX-License-Identifier: Apache-2.0
// Detects that more than one program commands the base.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tandem/model/stamped.hpp"

namespace tandem {

/// Tracks the sources of a base's velocity commands. On an open bus nothing prevents a second
/// program from publishing cmd_vel past the safety filter; a base that listens to both would
/// alternate between their commands.
///
/// The Twist and the TwistStamped writer of one process count as one source, because a node may
/// publish both. Processes are identified by the first eight bytes of the GUID, in which Fast DDS
/// encodes vendor, host and process. Under DDS Security these bytes are hashes with the first bit
/// set; then the first six bytes identify the enclave, and are used instead.
class SingleSource {
 public:
  using Writer = std::array<std::uint8_t, 16>;
  enum class Type { kTwist, kTwistStamped };

  /// `timeout`: time for which a source counts after its last command [s].
  explicit SingleSource(double timeout) : timeout_{timeout} {}

  /// Takes a command that arrived at time `t` [s]. Returns whether its source is the only one, so
  /// that the command may be executed.
  [[nodiscard]] bool on_command(const Writer& writer, Type type, double t);

 private:
  struct Sender {
    Writer writer;
    Type type;
  };

  [[nodiscard]] static bool same_source(const Sender& a, const Sender& b);

  double timeout_;
  std::vector<Stamped<Sender>> heard_;  // one per writer within the timeout
};

}  // namespace tandem
