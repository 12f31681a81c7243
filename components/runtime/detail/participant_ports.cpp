// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/participant_ports.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

#include "tandem/runtime/log.hpp"

namespace tandem::runtime {
namespace {

constexpr int kBase = 7400, kPerDomain = 250, kOfParticipants = 10, kPerParticipant = 2;
constexpr int kMaxPort = 65535;

bool is_free(int port) {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return true;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  const bool free = bind(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(probe);
  return free;
}

}  // namespace

// The port after that of discovery is the participant's, too: it receives the topics' samples.
int max_participant_id(int domain) {
  const int last = std::min(kBase + kPerDomain * (domain + 2) - 1, kMaxPort);
  return (last - 1 - discovery_port(domain, 0)) / kPerParticipant;
}

int discovery_port(int domain, int id) {
  return kBase + kPerDomain * domain + kOfParticipants + kPerParticipant * id;
}

std::optional<int> participant_id(int domain, std::uint32_t port) {
  const int offset = static_cast<int>(port) - discovery_port(domain, 0);
  const int id = offset / kPerParticipant;
  if (offset < 0 || offset % kPerParticipant != 0 || id > max_participant_id(domain))
    return std::nullopt;
  return id;
}

int multicast_port(int domain) { return kBase + kPerDomain * domain; }

int first_free_id(int domain) {
  const int last = max_participant_id(domain);
  for (int id = 0; id < last; ++id) {
    const int port = discovery_port(domain, id);
    if (port != multicast_port(domain + 1) && is_free(port)) return id;
  }
  return last;
}

void warn_if_deaf(const Environment& environment, bool has_multicast) {
  if (environment.range == DiscoveryRange::kLocalhost || has_multicast) return;
  Logger{"runtime"}.warn(
      "UDP port {}, on which the participants of domain {} hear of each other, is taken by another "
      "program, so they may stay unseen: stop that program, or set ROS_DOMAIN_ID to another domain",
      multicast_port(environment.domain), environment.domain);
}

}  // namespace tandem::runtime
