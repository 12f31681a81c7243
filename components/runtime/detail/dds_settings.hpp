// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: Fast DDS's own environment variables, checked before it reads them.
#pragma once

#include <string>

namespace tandem::runtime {

/// Throws std::runtime_error naming the variable, what is wrong and how to mend it, where Fast DDS
/// would log an error and go on with its defaults: a profile meant to keep DDS on one network
/// interface would then open them all.
void check_dds_settings();

/// Throws std::runtime_error if `servers` is no value of ROS_DISCOVERY_SERVER: locators separated
/// by
/// ';', some of which may be empty, each HOST, HOST:PORT, [IPV6]:PORT or one of these in the form
/// UDPv4:[HOST]:PORT (UDPv6, TCPv4, TCPv6), where HOST is an address or a name that resolves.
void check_discovery_servers(const std::string& servers);

}  // namespace tandem::runtime
