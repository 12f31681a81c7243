// SPDX-License-Identifier: Apache-2.0
// Tests that participants find each other however many there are on a host. Participants are cheap
// to imitate: what counts are the UDP ports that they occupy.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/child_process.hpp"
#include "support/instrumented.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/participant_ports.hpp"
#include "tandem/runtime/domain_view.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using test::ChildProcess;
using test::spin_until;

constexpr double kLong = 120.0;  // [s] for what takes a few on a quiet machine

int this_domain() { return std::atoi(std::getenv("ROS_DOMAIN_ID")); }

class OccupiedPort {
 public:
  explicit OccupiedPort(int port) : socket_{socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
    close(socket_);
    throw std::runtime_error("port " + std::to_string(port) + " is in use");
  }
  ~OccupiedPort() { close(socket_); }
  OccupiedPort(const OccupiedPort&) = delete;
  OccupiedPort& operator=(const OccupiedPort&) = delete;

 private:
  int socket_;
};

// Occupies the ports of the first `count` participants.
class OccupiedIds {
 public:
  explicit OccupiedIds(int count) {
    for (int id = 0; id < count; ++id)
      for (const int port : {0, 1})
        ports_.push_back(
            std::make_unique<OccupiedPort>(rt::discovery_port(this_domain(), id) + port));
  }

 private:
  std::vector<std::unique_ptr<OccupiedPort>> ports_;
};

// The next two domains are kept free, because the ids from 120 on use their ports.
class ManyParticipants : public testing::Test {
 protected:
  ~ManyParticipants() override {
    unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
    setenv("ROS_LOCALHOST_ONLY", "1", 1);
  }

  static void discover_by_unicast() {
    unsetenv("ROS_LOCALHOST_ONLY");
    setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST", 1);
  }

  static void expect_to_find_a_peer() {
    ChildProcess peer{"peer", {"echo"}};
    rt::Node node{"seeker"};
    const auto ping = node.create_publisher(rt::Topic<Twist>{"ping"});
    EXPECT_TRUE(spin_until([&] { return ping.matched() == 1; }, kLong, node));
  }

  test::PrivateDomain domain_{2};
};

TEST_F(ManyParticipants, FindEachOtherByMulticastBeyondAHundred) {
  const OccupiedIds others{110};
  expect_to_find_a_peer();
}

TEST_F(ManyParticipants, FindEachOtherByUnicastBeyondThirtyTwo) {
  const OccupiedIds others{40};
  discover_by_unicast();
  expect_to_find_a_peer();
}

TEST_F(ManyParticipants, FindEachOtherByUnicastBeyondAHundred) {
  const OccupiedIds others{150};
  discover_by_unicast();
  expect_to_find_a_peer();
}

// None of them knows, when it starts, how many there will be.
TEST_F(ManyParticipants, FindEachOtherByUnicastIfAllStartAtOnce) {
  constexpr int kProcesses = test::samples(40, 8);
  discover_by_unicast();
  std::vector<std::unique_ptr<ChildProcess>> processes;
  for (int i = 0; i < kProcesses; ++i)
    processes.push_back(std::make_unique<ChildProcess>(
        "peer", std::vector<std::string>{"meet", std::to_string(kProcesses)}));
  rt::Node node{"counter"};
  constexpr rt::QoS kOfAll{.durability = rt::Durability::kTransientLocal, .depth = kProcesses};
  int met = 0;
  const auto of_all =
      node.create_subscription(rt::Topic<Twist>{"met", kOfAll}, [&](const auto&) { ++met; });
  EXPECT_TRUE(spin_until([&] { return met == kProcesses; }, kLong, node)) << met;
}

TEST_F(ManyParticipants, OneThatIsMadeAnewTakesItsOldPorts) {
  for (const bool by_unicast : {false, true}) {
    if (by_unicast) discover_by_unicast();
    for (int time = 0; time < 3; ++time) {
      ASSERT_EQ(rt::first_free_id(this_domain()), 0) << by_unicast << time;
      const rt::Node node{"again"};
      EXPECT_EQ(rt::first_free_id(this_domain()), 1) << by_unicast << time;
    }
  }
}

// Then no participant of the domain hears another one's announcement.
TEST_F(ManyParticipants, AreWarnedIfAnotherProgramHasTheMulticastPort) {
  const OccupiedPort taken{rt::multicast_port(this_domain())};
  testing::internal::CaptureStderr();
  const rt::Node node{"deaf"};
  EXPECT_NE(testing::internal::GetCapturedStderr().find("is taken by another program"),
            std::string::npos);
}

TEST_F(ManyParticipants, LeaveTheNextDomainsMulticastPortFree) {
  const OccupiedIds others{rt::kIdsOfDomain};
  EXPECT_EQ(rt::discovery_port(this_domain(), rt::kIdsOfDomain),
            rt::multicast_port(this_domain() + 1));
  EXPECT_EQ(rt::first_free_id(this_domain()), rt::kIdsOfDomain + 1);
}

// `tandem doctor` warns of them.
TEST_F(ManyParticipants, FromTheHundredAndTwentyFirstOnAreSeenToUseTheNextDomainsPorts) {
  for (const int others : {rt::kIdsOfDomain - 2, rt::kIdsOfDomain}) {  // and two of this test
    const OccupiedIds occupied{others};
    ChildProcess peer{"peer", {"echo"}};
    rt::Node node{"seeker"};
    const rt::DomainView view{node};
    const auto peer_borrows = [&]() -> std::optional<bool> {
      for (const auto& participant : view.look().participants)
        if (!participant.ours) return participant.borrows_ports;
      return std::nullopt;
    };
    ASSERT_TRUE(spin_until([&] { return peer_borrows().has_value(); }, kLong, node));
    EXPECT_EQ(peer_borrows(), others == rt::kIdsOfDomain) << others;
  }
}

TEST_F(ManyParticipants, OneThatFindsNoFreePortIsRefused) {
  const OccupiedIds others{rt::max_participant_id(this_domain()) + 1};
  try {
    const rt::Node node{"one_too_many"};
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string{error.what()}.find("no free UDP port left"), std::string::npos)
        << error.what();
  }
}

TEST(ParticipantPorts, AreThoseOfTheStandard) {
  EXPECT_EQ(rt::discovery_port(0, 0), 7410);
  EXPECT_EQ(rt::discovery_port(3, 7), 7400 + 3 * 250 + 10 + 2 * 7);
  EXPECT_EQ(rt::participant_id(3, 8174), 7);
  EXPECT_EQ(rt::participant_id(3, 8175), std::nullopt);  // receives samples
  EXPECT_EQ(rt::participant_id(3, 8150), std::nullopt);  // multicast
  EXPECT_EQ(rt::participant_id(3, 8160 + 250), 125);     // also the first of the next domain
  EXPECT_EQ(rt::participant_id(3, 8160 + 500), std::nullopt);
}

TEST(ParticipantPorts, OfIdsFromOneHundredAndTwentyOnAreThoseOfTheNextDomain) {
  EXPECT_LT(rt::discovery_port(5, rt::kIdsOfDomain - 1) + 1, 7400 + 6 * 250);
  EXPECT_EQ(rt::discovery_port(5, rt::kIdsOfDomain), 7400 + 6 * 250);
}

TEST(ParticipantPorts, AreNeverThoseOfTheSecondNextDomainNorAbove65535) {
  EXPECT_EQ(rt::max_participant_id(0), 244);
  for (int domain = 0; domain <= 232; ++domain) {
    const int last = rt::discovery_port(domain, rt::max_participant_id(domain)) + 1;
    EXPECT_LT(last, 7400 + 250 * (domain + 2)) << domain;
    EXPECT_LE(last, 65535) << domain;
  }
}

}  // namespace
}  // namespace tandem
