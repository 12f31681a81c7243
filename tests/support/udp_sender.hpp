// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace tandem::test {

/// UDP ports of RTPS in the domain that the environment sets (RTPS 2.5, 9.6.2).
class RtpsPorts {
 public:
  [[nodiscard]] static std::uint16_t multicast() { return port(0); }
  [[nodiscard]] static std::uint16_t discovery(int participant) {
    return port(10 + 2 * participant);
  }
  [[nodiscard]] static std::uint16_t user(int participant) { return port(11 + 2 * participant); }
  [[nodiscard]] static bool in_domain(std::uint16_t port) {
    return port >= multicast() && port < multicast() + 250;
  }

 private:
  static std::uint16_t port(int offset) {
    const char* domain = std::getenv("ROS_DOMAIN_ID");
    return static_cast<std::uint16_t>(7400 + 250 * (domain == nullptr ? 0 : std::atoi(domain)) +
                                      offset);
  }
};

/// Sends datagrams over loopback.
class UdpSender {
 public:
  UdpSender() : socket_{socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
    if (socket_ < 0) throw std::runtime_error("no socket");
    in_addr loopback{};
    loopback.s_addr = htonl(INADDR_LOOPBACK);
    setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof loopback);
  }
  ~UdpSender() { close(socket_); }
  UdpSender(const UdpSender&) = delete;
  UdpSender& operator=(const UdpSender&) = delete;

  void send(const std::vector<std::uint8_t>& octets, std::uint16_t port,
            const char* address = "127.0.0.1") const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    inet_pton(AF_INET, address, &to.sin_addr);
    (void)sendto(socket_, octets.data(), octets.size(), 0, reinterpret_cast<sockaddr*>(&to),
                 sizeof to);
  }

  /// Sends to all ports of the first `participants` of the domain, and to all by multicast.
  void send_to_all(const std::vector<std::uint8_t>& octets, int participants) const {
    for (int participant = 0; participant < participants; ++participant) {
      send(octets, RtpsPorts::discovery(participant));
      send(octets, RtpsPorts::user(participant));
    }
    send(octets, RtpsPorts::multicast(), "239.255.0.1");
  }

 private:
  int socket_;
};

}  // namespace tandem::test
