// SPDX-License-Identifier: Apache-2.0
// Checks Fast DDS's own environment variables before it reads them. Private to runtime/.
#pragma once

#include <string>

#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

inline constexpr const char* kServersVariable = "ROS_DISCOVERY_SERVER";

/// Throws std::runtime_error naming the variable, the fault and the remedy. Fast DDS would only log
/// an error and use its defaults: a broken profile that restricts DDS to one network interface
/// would open all of them.
void check_dds_settings();

/// Throws std::runtime_error if `servers` is not a valid ROS_DISCOVERY_SERVER: locators separated
/// by ';', possibly empty, each of the form HOST, HOST:PORT, [IPV6]:PORT or one of these in the
/// form UDPv4:[HOST]:PORT (UDPv6, TCPv4, TCPv6), where HOST is an address or a name that resolves.
TANDEM_EXPORT_FOR_TESTS void check_discovery_servers(const std::string& servers);

/// Has the participants of this process announce endpoints to each other by the network, as to
/// those of other processes. By Fast DDS's direct calls they now and then stayed without each
/// other's endpoints for good (2.9.1: in about one of a hundred starts while endpoints came and
/// went). Does not change another setting of a profile. Call it before a participant is created and
/// after profiles are loaded.
void announce_by_network();

/// Makes the participant learn of everything behind a discovery server if ROS_SUPER_CLIENT is TRUE,
/// true, True or 1.
void set_super_client(fdds::DomainParticipantQos& qos);

}  // namespace tandem::runtime
