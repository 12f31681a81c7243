// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/client_address.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace tandem {
namespace {

namespace ip = boost::asio::ip;

// Maps "::ffff:10.0.0.1" to "10.0.0.1".
ip::address plain(const ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return ip::make_address_v4(ip::v4_mapped, address.to_v6());
}

std::optional<ip::address> parse(const std::string& text) {
  boost::system::error_code error;
  const auto address = ip::make_address(text, error);
  return error ? std::nullopt : std::optional{plain(address)};
}

std::string key(const ip::address& address) {
  if (address.is_v4()) return address.to_string();
  auto bytes = address.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
  return ip::address_v6{bytes}.to_string() + "/64";
}

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// Accepts "10.0.0.1:1234" and "[::1]:1234", which some proxies write, too.
std::optional<ip::address> parse_forwarded(std::string_view text) {
  const std::string whole{trimmed(text)};
  if (whole.starts_with("[")) return parse(whole.substr(1, whole.find(']') - 1));
  const bool has_port = std::count(whole.begin(), whole.end(), ':') == 1;
  return parse(has_port ? whole.substr(0, whole.find(':')) : whole);
}

}  // namespace

TrustedProxies trusted_proxies(const std::string& addresses) {
  TrustedProxies all;
  std::istringstream list{addresses};
  for (std::string text; list >> text;) {
    const auto address = parse(text);
    if (!address)
      throw std::invalid_argument("trusted_proxies: \"" + text +
                                  "\" is not an IP address (127.0.0.1, ::1, ...)");
    all.insert(*address);
  }
  return all;
}

bool is_trusted(const ip::address& peer, const TrustedProxies& trusted) {
  return trusted.contains(plain(peer));
}

std::string client_address(const ip::address& peer, std::string_view forwarded_for,
                           const TrustedProxies& trusted) {
  ip::address client = plain(peer);
  while (trusted.contains(client) && !forwarded_for.empty()) {
    const auto comma = forwarded_for.rfind(',');
    const auto last =
        comma == std::string_view::npos ? forwarded_for : forwarded_for.substr(comma + 1);
    const auto address = parse_forwarded(last);
    if (!address) break;
    client = *address;
    forwarded_for = forwarded_for.substr(0, comma == std::string_view::npos ? 0 : comma);
  }
  return key(client);
}

}  // namespace tandem
