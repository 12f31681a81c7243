// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: what ROS 2 users say by environment variables.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tandem/runtime/dds_security.hpp"

namespace tandem::runtime {

/// How far discovery reaches: everything multicast reaches, this host, nobody.
enum class DiscoveryRange { kSubnet, kLocalhost, kOff };

struct Environment {
  int domain = 0;                                  ///< ROS_DOMAIN_ID
  DiscoveryRange range = DiscoveryRange::kSubnet;  ///< ROS_AUTOMATIC_DISCOVERY_RANGE
  bool loopback_only = false;             ///< ROS_LOCALHOST_ONLY=1, as Humble understands it
  std::vector<std::string> static_peers;  ///< ROS_STATIC_PEERS, a;b;c
  bool humble = false;                ///< ROS_DISTRO=humble: speak to ROS 2 as it was before Iron
  SecurityRequest security;           ///< ROS_SECURITY_…
  bool unguarded_transports = false;  ///< TANDEM_UNGUARDED_TRANSPORTS=1: others than UDP too
};

/// The value of an environment variable; empty if it is not set.
[[nodiscard]] std::string variable(const char* name);

/// TANDEM_MAX_SAMPLE_SIZE [bytes]: fragmented samples above it are dropped. Throws
/// std::runtime_error if it is no integer of its range.
[[nodiscard]] std::uint32_t largest_sample();

/// Throws std::runtime_error naming the variable, its value and what it may be.
[[nodiscard]] Environment read_environment();

}  // namespace tandem::runtime
