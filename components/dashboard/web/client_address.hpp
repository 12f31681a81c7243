// SPDX-License-Identifier: Apache-2.0
// In: where a connection comes from, and what a proxy says about it. Out: whose it is.
#pragma once

#include <set>
#include <string>
#include <string_view>

#include <boost/asio/ip/address.hpp>

namespace tandem {

/// Proxies whose X-Forwarded-For is believed.
using TrustedProxies = std::set<boost::asio::ip::address>;

/// Of addresses with spaces between them. Throws std::invalid_argument in one line for what is no
/// IP address.
[[nodiscard]] TrustedProxies trusted_proxies(const std::string& addresses);

/// Whether the peer is one of them.
[[nodiscard]] bool is_trusted(const boost::asio::ip::address& peer, const TrustedProxies& trusted);

/// What the limits count by: the peer, or for a trusted proxy's connection the last address in its
/// X-Forwarded-For that is no trusted proxy itself (anybody can write what stands before it). Of an
/// IPv6 address the first 64 bits, which one subscriber has for itself.
[[nodiscard]] std::string client_address(const boost::asio::ip::address& peer,
                                         std::string_view forwarded_for,
                                         const TrustedProxies& trusted);

}  // namespace tandem
