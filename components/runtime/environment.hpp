// SPDX-License-Identifier: Apache-2.0
// Reads the environment variables of ROS 2 and of this runtime. Private to runtime/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tandem/runtime/dds_security.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Discovery range: everything that multicast reaches, this host only, or off.
enum class DiscoveryRange { kSubnet, kLocalhost, kOff };

/// The settings of ROS 2's environment variables.
struct Environment {
  int domain = 0;                                  ///< ROS_DOMAIN_ID
  DiscoveryRange range = DiscoveryRange::kSubnet;  ///< ROS_AUTOMATIC_DISCOVERY_RANGE
  bool loopback_only = false;                      ///< ROS_LOCALHOST_ONLY=1 with Humble's meaning
  std::vector<std::string> static_peers;           ///< ROS_STATIC_PEERS, a;b;c
  bool humble = false;                ///< ROS_DISTRO=humble: use the wire format before Iron
  SecurityRequest security;           ///< ROS_SECURITY_…
  bool unguarded_transports = false;  ///< TANDEM_UNGUARDED_TRANSPORTS=1: not only UDP
};

/// The value of an environment variable; empty if it is not set.
[[nodiscard]] TANDEM_EXPORT std::string variable(const char* name);

/// TANDEM_MAX_SAMPLE_SIZE [bytes]: fragmented samples above it are dropped. Throws
/// std::runtime_error if it is not an integer in the accepted range.
[[nodiscard]] TANDEM_EXPORT std::uint32_t largest_sample();

/// Throws std::runtime_error naming the variable, its value and the accepted values.
[[nodiscard]] TANDEM_EXPORT Environment read_environment();

}  // namespace tandem::runtime
