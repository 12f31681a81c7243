// SPDX-License-Identifier: Apache-2.0
// Attacks a running system with datagrams and measures the effect.
#pragma once

#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <poll.h>

#include <map>
#include <random>
#include <set>

#include "runtime/datagram.hpp"
#include "support/memory_of.hpp"
#include "support/udp_losses.hpp"
#include "support/udp_sender.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {

/// A datagram and its destination.
struct Stamped {
  Octets octets;
  std::uint16_t port;
};

/// Captures this domain's RTPS datagrams on loopback.
class LoopbackTap {
 public:
  LoopbackTap() : socket_{socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP))} {
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_IP);
    address.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
    if (socket_ >= 0) (void)bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address);
  }
  ~LoopbackTap() {
    if (socket_ >= 0) close(socket_);
  }
  LoopbackTap(const LoopbackTap&) = delete;
  LoopbackTap& operator=(const LoopbackTap&) = delete;

  /// False if capturing is not permitted (it needs CAP_NET_RAW).
  [[nodiscard]] bool works() const { return socket_ >= 0; }

  /// The datagrams seen within `duration` [s], at most `most`.
  [[nodiscard]] std::vector<Stamped> listen(double duration, std::size_t most) const {
    std::vector<Stamped> heard;
    Octets packet(1 << 16);
    for (const double end = rt::steady_seconds() + duration;
         rt::steady_seconds() < end && heard.size() < most;) {
      pollfd readable{socket_, POLLIN, 0};
      if (poll(&readable, 1, 50) <= 0) continue;
      const ssize_t size = recv(socket_, packet.data(), packet.size(), 0);
      if (size > 28) add({packet.begin(), packet.begin() + size}, heard);
    }
    return heard;
  }

 private:
  static void add(const Octets& packet, std::vector<Stamped>& heard) {
    constexpr std::uint8_t kUdp = 17;
    const std::size_t header = (packet[0] & 0xfU) * 4U;
    if (packet[9] != kUdp || packet.size() < header + 28) return;
    const auto port = static_cast<std::uint16_t>(packet[header + 2] << 8 | packet[header + 3]);
    const Octets octets{packet.begin() + static_cast<std::ptrdiff_t>(header) + 8, packet.end()};
    if (octets[0] != 'R' || octets[1] != 'T' || !RtpsPorts::in_domain(port)) return;
    heard.push_back({octets, port});
  }

  int socket_;
};

/// Mutates datagrams as an attacker does who does not know the format.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_{seed} {}

  /// Keeps the header, and with it the GUID.
  [[nodiscard]] Octets mutate(Octets octets) {
    constexpr std::size_t kHeader = 20;
    if (octets.size() <= kHeader + 4) return octets;
    for (auto changes = 1 + random_() % 4; changes > 0; --changes) {
      const std::size_t at = kHeader + random_() % (octets.size() - kHeader);
      change(octets, at);
    }
    if (random_() % 8 == 0) octets.resize(kHeader + random_() % (octets.size() - kHeader));
    return octets;
  }
  [[nodiscard]] std::size_t below(std::size_t end) { return random_() % end; }

 private:
  void change(Octets& octets, std::size_t at) {
    static constexpr std::uint8_t kEdges[] = {0, 1, 2, 0x7f, 0x80, 0xfe, 0xff, 0x06, 0x08, 0x16};
    switch (random_() % 4) {
      case 0:
        octets[at] ^= static_cast<std::uint8_t>(1U << random_() % 8);
        break;
      case 1:
        octets[at] = kEdges[random_() % std::size(kEdges)];
        break;
      case 2:
        octets[at] = static_cast<std::uint8_t>(random_());
        break;
      default:  // an integer
        std::fill_n(octets.begin() + static_cast<std::ptrdiff_t>(at),
                    std::min<std::size_t>(4, octets.size() - at),
                    kEdges[random_() % std::size(kEdges)]);
    }
  }

  std::mt19937 random_;
};

/// A driving system of nine processes, including the watcher.
class AttackedSystem {
 public:
  AttackedSystem() {
    system_.start_all();
    diagnostics_ = system_.node().create_subscription(topics::diagnostics, [this](const auto& msg) {
      for (const auto& status : msg.status())
        for (const auto& value : status.values())
          if (value.key() == "received" || value.key() == "dropped")
            counts_[value.key()][status.name()] = std::stod(value.value());
    });
  }

  [[nodiscard]] SystemUnderTest& system() { return system_; }
  void note_memory() {
    for (const char* name : kComponents) before_[name] = memory_of(system_.process(name).pid());
  }
  /// Largest memory growth of any process [MB].
  [[nodiscard]] double growth() {
    double most = 0.0;
    for (const char* name : kComponents)
      most = std::max(most, memory_of(system_.process(name).pid()) - before_[name]);
    return most;
  }
  [[nodiscard]] bool all_alive() {
    return std::all_of(std::begin(kComponents), std::end(kComponents), [this](const char* name) {
      return memory_of(system_.process(name).pid()) > 0.0;
    });
  }
  /// Datagrams that the guards of all processes received or dropped, from their latest reports.
  [[nodiscard]] double count(const std::string& which) const {
    double sum = 0.0;
    const auto counts = counts_.find(which);
    if (counts == counts_.end()) return 0.0;
    for (const auto& [name, value] : counts->second) sum += value;
    return sum;
  }
  [[nodiscard]] bool stops() {
    const auto button = system_.node().create_publisher(topics::e_stop);
    std_msgs::msg::Bool pressed;
    pressed.data(true);
    button.publish(pressed);
    return system_.wait_until([&] { return system_.stands(); }, 10.0);
  }

  /// Sends `count` mutated datagrams, half from the corpus and half from `session`, to ports on
  /// which somebody listens. Returns how many reached a guard: those sent without those of this
  /// domain, mutated or not, that the kernel discarded meanwhile.
  [[nodiscard]] long send_mutated(long count, const std::vector<Stamped>& session, unsigned seed) {
    Mutator mutator{seed};
    const auto before = udp_losses();
    long sent = 0;
    for (long i = 0; i < count; ++i) {
      const auto& heard = session[mutator.below(session.size())];
      const bool of_session = i % 2 == 0;
      const Octets& octets = of_session ? heard.octets : corpus_[mutator.below(corpus_.size())];
      pace(i);
      if (!before.contains(heard.port)) continue;
      sender_.send(mutator.mutate(octets), heard.port);
      ++sent;
    }
    return sent - lost_since(before);
  }

  /// Announces `count` participants and endpoints that do not exist: one participant for each three
  /// endpoints.
  void announce(long count) {
    for (long i = 0; i < count; ++i) {
      const long participant = i / 4;
      Octets octets = i % 4 == 0 ? announcement(participant) : endpoint(participant, i % 4);
      sender_.send(octets, RtpsPorts::discovery(static_cast<int>(participant % 9)));
      if (i % 4 == 0) sender_.send(octets, RtpsPorts::multicast(), "239.255.0.1");
      pace(i);
    }
  }

 private:
  // Paces the sender so that few datagrams are lost before they are received.
  void pace(long sent) {
    constexpr long kBurst = 20;
    if (sent % kBurst == 0) system_.node().spin_some(0.002);
  }

  static std::vector<Octets> corpus() {
    std::vector<Octets> corpus;
    for (const char* folder : {"hostile", "sessions"})
      for (const auto& file : datagram_files(folder)) corpus.push_back(read(file));
    return corpus;
  }
  static long lost_since(const std::map<std::uint16_t, long>& before) {
    long lost = 0;
    for (const auto& [port, count] : udp_losses())
      if (const auto old = before.find(port); RtpsPorts::in_domain(port) && old != before.end())
        lost += count - old->second;
    return lost;
  }

  static Octets prefix(long participant) {
    Octets prefix{1, 15, 9, 9, 9, 9, 9, 9};
    append(prefix, static_cast<std::uint32_t>(participant), true);
    return prefix;
  }
  static Octets guid(long participant, std::uint32_t entity) {
    Octets guid = prefix(participant);
    append(guid, entity, false);
    return guid;
  }
  static Octets text(const std::string& string) {
    Octets octets;
    append(octets, static_cast<std::uint32_t>(string.size() + 1), true);
    octets.insert(octets.end(), string.begin(), string.end());
    octets.push_back(0);
    return octets;
  }
  static Octets locator() {
    Octets octets{1, 0, 0, 0, 1, 0, 0, 0};  // UDPv4, port 1: nothing listens there
    octets.resize(20);
    octets.insert(octets.end(), {127, 0, 0, 1});
    return octets;
  }
  static Octets announcement(long participant) {
    constexpr std::uint32_t kParticipant = 0x000001c1, kSpdp = 0x000100c2;
    return Datagram{}
        .vendor(0x010f)
        .prefix(prefix(participant))
        .add_announcement(kSpdp, {{0x15, {2, 3, 0, 0}},
                                  {0x16, {1, 15, 0, 0}},
                                  {0x50, guid(participant, kParticipant)},
                                  {0x32, locator()},
                                  {0x31, locator()},
                                  {0x02, {100, 0, 0, 0, 0, 0, 0, 0}},
                                  {0x58, {0x3f, 0x0c, 0, 0}}})
        .octets();
  }
  static Octets endpoint(long participant, long number) {
    constexpr std::uint32_t kPublications = 0x000003c2;
    const auto entity = static_cast<std::uint32_t>(number << 8 | 0x03);
    return Datagram{}
        .vendor(0x010f)
        .prefix(prefix(participant))
        .add_data({.reader = 0x000003c7, .writer = kPublications, .number = number},
                  Datagram::list_payload({{0x5a, guid(participant, entity)},
                                          {0x50, guid(participant, 0x000001c1)},
                                          {0x05, text("rt/nothing_" + std::to_string(number))},
                                          {0x07, text("std_msgs::msg::dds_::String_")},
                                          {0x70, guid(participant, entity)},
                                          {0x1a, {2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}}},
                                         true))
        .octets();
  }

  SystemUnderTest system_;
  rt::Subscription diagnostics_;
  std::map<std::string, std::map<std::string, double>> counts_;
  std::map<std::string, double> before_;
  const std::vector<Octets> corpus_ = corpus();
  UdpSender sender_;
};

}  // namespace tandem::test
