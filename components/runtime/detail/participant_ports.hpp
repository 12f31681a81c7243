// SPDX-License-Identifier: Apache-2.0
// Computes the UDP ports on which participants are discovered (OMG RTPS 2.5, 9.6.2.3). Private to
// runtime/.
#pragma once

#include <cstdint>
#include <optional>

#include "tandem/runtime/environment.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

inline constexpr int kIdsAsked = 32;      ///< ids that ROS 2 asks on a host by unicast
inline constexpr int kIdsOfDomain = 120;  ///< ids from this one on use ports of the next domain

/// The largest participant id that a participant of `domain` may take on a host. Its ports are at
/// most the last ones of the next domain, and at most 65535.
[[nodiscard]] TANDEM_EXPORT_FOR_TESTS int max_participant_id(int domain);

/// The port on which the participant `id` of a host is discovered.
[[nodiscard]] TANDEM_EXPORT_FOR_TESTS int discovery_port(int domain, int id);

/// The id of the participant that is discovered on `port`; nullopt if no participant of `domain`
/// is.
[[nodiscard]] TANDEM_EXPORT_FOR_TESTS std::optional<int> participant_id(int domain,
                                                                        std::uint32_t port);

/// The port on which all participants of `domain` hear those that announce themselves by multicast.
[[nodiscard]] TANDEM_EXPORT_FOR_TESTS int multicast_port(int domain);

/// The first id whose port is free on this host; max_participant_id() if none is. Leaves out the id
/// whose port is the next domain's multicast port: a participant there would make that domain deaf.
[[nodiscard]] TANDEM_EXPORT_FOR_TESTS int first_free_id(int domain);

/// Logs a warning if a participant that should hear of others by multicast does not.
void warn_if_deaf(const Environment& environment, bool has_multicast);

}  // namespace tandem::runtime
