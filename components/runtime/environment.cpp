// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/environment.hpp"

#include <charconv>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace tandem::runtime {
namespace {

constexpr int kMaxDomain = 232;  // above it the well-known ports exceed 65535

// An integer from `least` to `most`; `value` if the variable is not set.
int integer_from(const char* name, int value, int least, int most) {
  const std::string text = variable(name);
  if (text.empty()) return value;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < least || value > most)
    throw std::runtime_error(std::string{name} + " = '" + text + "' is not an integer from " +
                             std::to_string(least) + " to " + std::to_string(most));
  return value;
}

DiscoveryRange range_from(const std::string& text) {
  if (text.empty() || text == "SUBNET" || text == "SYSTEM_DEFAULT") return DiscoveryRange::kSubnet;
  if (text == "LOCALHOST") return DiscoveryRange::kLocalhost;
  if (text == "OFF") return DiscoveryRange::kOff;
  throw std::runtime_error("ROS_AUTOMATIC_DISCOVERY_RANGE = '" + text +
                           "' is not one of {SUBNET, LOCALHOST, OFF, SYSTEM_DEFAULT}");
}

bool flag_from(const char* name) {
  const std::string text = variable(name);
  if (text.empty() || text == "0") return false;
  if (text == "1") return true;
  throw std::runtime_error(std::string{name} + " = '" + text + "' is neither 0 nor 1");
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream{text};
  for (std::string part; std::getline(stream, part, separator);)
    if (!part.empty()) parts.push_back(part);
  return parts;
}

}  // namespace

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// The default exceeds the largest map that a subscription accepts.
std::uint32_t largest_sample() {
  constexpr int kUsual = 64 << 20, kMin = 1 << 16, kMax = 1 << 30;
  return static_cast<std::uint32_t>(integer_from("TANDEM_MAX_SAMPLE_SIZE", kUsual, kMin, kMax));
}

Environment read_environment() {
  const std::string distribution = variable("ROS_DISTRO");
  Environment environment{.domain = integer_from("ROS_DOMAIN_ID", 0, 0, kMaxDomain),
                          .range = range_from(variable("ROS_AUTOMATIC_DISCOVERY_RANGE")),
                          .loopback_only = flag_from("ROS_LOCALHOST_ONLY"),
                          .static_peers = split(variable("ROS_STATIC_PEERS"), ';'),
                          .humble = distribution == "humble",
                          .security = read_security_request(),
                          .unguarded_transports = flag_from("TANDEM_UNGUARDED_TRANSPORTS")};
  const bool since_iron = !distribution.empty() && !environment.humble;
  if (environment.loopback_only && since_iron) {  // since Iron a deprecated range setting that wins
    environment.loopback_only = false;
    environment.range = DiscoveryRange::kLocalhost;
    environment.static_peers.clear();
  }
  return environment;
}

}  // namespace tandem::runtime
