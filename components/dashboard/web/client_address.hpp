// SPDX-License-Identifier: Apache-2.0
// Determines a client's address, also behind reverse proxies.
#pragma once

#include <set>
#include <string>
#include <string_view>

#include <boost/asio/ip/address.hpp>

namespace tandem {

/// Proxies whose X-Forwarded-For is trusted.
using TrustedProxies = std::set<boost::asio::ip::address>;

/// Parses addresses separated by spaces. Throws std::invalid_argument with one line for anything
/// that is not an IP address.
[[nodiscard]] TrustedProxies trusted_proxies(const std::string& addresses);

/// Whether the peer is a trusted proxy.
[[nodiscard]] bool is_trusted(const boost::asio::ip::address& peer, const TrustedProxies& trusted);

/// The address that limits are applied to: the peer, or, for a connection from a trusted proxy, the
/// last address in X-Forwarded-For that is not itself a trusted proxy (earlier entries can be
/// forged). Of an IPv6 address only the first 64 bits, because one subscriber has the whole
/// network.
[[nodiscard]] std::string client_address(const boost::asio::ip::address& peer,
                                         std::string_view forwarded_for,
                                         const TrustedProxies& trusted);

}  // namespace tandem
