// SPDX-License-Identifier: Apache-2.0
// In: who sent each command. Out: whether more than one program commands the base.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace tandem {

/// The sources of a base's velocity command. On an open bus nothing keeps a second program from
/// publishing cmd_vel past the safety filter; a base that listens to both drives now as the one
/// wants and now as the other.
///
/// The Twist and the TwistStamped writer of one process count as one source, because a node may
/// publish both. Processes are told apart by the first eight bytes of the GUID, as Fast DDS makes
/// it: vendor, host and process. Under DDS Security it makes them of hashes, the first bit set: the
/// first six bytes are then the enclave's, and stand for the process.
class SingleSource {
 public:
  using Writer = std::array<std::uint8_t, 16>;
  enum class Type { kTwist, kTwistStamped };

  /// `timeout`: how long a source counts after its last command [s].
  explicit SingleSource(double timeout) : timeout_{timeout} {}

  /// A command arrived at time `t` [s]. Whether its source is alone, so that it may drive.
  [[nodiscard]] bool on_command(const Writer& writer, Type type, double t);

 private:
  struct Stamped {
    Writer writer;
    Type type;
    double t;
  };

  [[nodiscard]] static bool same_source(const Stamped& a, const Stamped& b);

  double timeout_;
  std::vector<Stamped> heard_;  // one for each writer within the timeout
};

}  // namespace tandem
