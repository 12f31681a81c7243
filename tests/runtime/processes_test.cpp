// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <vector>

#include "runtime/datagram.hpp"
#include "support/child_process.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "support/udp_sender.hpp"
#include "tandem/runtime/detail/dds_settings.hpp"
#include "tandem/runtime/detail/thread_limit.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using std_srvs::srv::Trigger;
using test::ChildProcess;
using test::spin_until;

using test::kTimeout;

TEST(TwoProcesses, ExchangeMessagesInBothDirections) {
  ChildProcess peer{"peer", {"echo"}};
  rt::Node node{"pinger"};
  std::vector<double> got;
  const auto ping = node.create_publisher(rt::Topic<Twist>{"ping"});
  const auto pong =
      node.create_subscription(rt::Topic<Twist>{"pong", rt::kLatched},
                               [&](const Twist& message) { got.push_back(message.linear().x()); });
  ASSERT_TRUE(
      spin_until([&] { return ping.matched() == 1 && pong.matched() == 1; }, kTimeout, node));
  // A write that waits longer than 10 ms for a thread of DDS, which a busy machine does not run, is
  // given up with a warning; a sender repeats what matters.
  for (int i = 0; i < 300; ++i) {
    Twist message;
    message.linear().x(i);
    const auto is_answered = [&] { return !got.empty() && got.back() == i; };
    int tries = 0;
    do {
      ASSERT_LE(++tries, 5) << i << "; matched: " << ping.matched() << ", " << pong.matched();
      ping.publish(message);
    } while (!spin_until(is_answered, 2.0, node));
  }
  EXPECT_TRUE(std::is_sorted(got.begin(), got.end()));
}

TEST(TwoProcesses, ClientGetsTheFirstAnswerOfALateServer) {
  rt::Node node{"asker"};
  const auto client = node.create_client(rt::ServiceName<Trigger>{"trigger"});
  std::string answer;
  client.call(
      {}, [&](const Trigger::Response& r) { answer = r.message(); }, kTimeout);
  ChildProcess peer{"peer", {"trigger"}};
  EXPECT_TRUE(spin_until([&] { return !answer.empty(); }, kTimeout, node));
  EXPECT_EQ(answer, "from another process");
}

// The environment variables by which ROS 2 users limit discovery.
struct Reach {
  const char* name;
  std::vector<std::pair<const char*, const char*>> environment;
  bool found;  // by another process of this host
};

class DiscoveryRange : public testing::TestWithParam<Reach> {
 protected:
  void SetUp() override {
    unsetenv("ROS_LOCALHOST_ONLY");
    for (const auto& [name, value] : GetParam().environment) setenv(name, value, 1);
  }
  void TearDown() override {
    for (const auto& [name, value] : GetParam().environment) unsetenv(name);
    setenv("ROS_LOCALHOST_ONLY", "1", 1);
  }
};

TEST_P(DiscoveryRange, ReachesAnotherProcessOfThisHost) {
  ChildProcess peer{"peer", {"echo"}};
  rt::Node node{"seeker"};
  const auto ping = node.create_publisher(rt::Topic<Twist>{"ping"});
  const double timeout = GetParam().found ? kTimeout : 1.0;
  EXPECT_EQ(spin_until([&] { return ping.matched() == 1; }, timeout, node), GetParam().found);
}

INSTANTIATE_TEST_SUITE_P(
    Environments, DiscoveryRange,
    testing::Values(
        Reach{"Default", {}, true},
        Reach{"Subnet", {{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}}, true},
        Reach{"Localhost", {{"ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"}}, true},
        Reach{"Off", {{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}}, false},
        Reach{"LocalhostWithPeer",
              {{"ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"}, {"ROS_STATIC_PEERS", "192.0.2.1"}},
              true},
        Reach{
            "LocalhostOnlySinceIron", {{"ROS_LOCALHOST_ONLY", "1"}, {"ROS_DISTRO", "jazzy"}}, true},
        Reach{
            "LocalhostOnlyOfKilted", {{"ROS_LOCALHOST_ONLY", "1"}, {"ROS_DISTRO", "kilted"}}, true},
        Reach{"LocalhostOnlyOfLyrical",
              {{"ROS_LOCALHOST_ONLY", "1"}, {"ROS_DISTRO", "lyrical"}},
              true},
        Reach{"SubnetWithPeers", {{"ROS_STATIC_PEERS", "192.0.2.1;127.0.0.1"}}, true},
        Reach{"SubnetWithPeersByName", {{"ROS_STATIC_PEERS", "localhost;192.0.2.1"}}, true}),
    [](const auto& reach) { return reach.param.name; });

TEST(Environment, NothingStartsIfItForbidsUnsecuredTrafficOrNamesAnUnknownHost) {
  setenv("ROS_SECURITY_ENABLE", "true", 1);
  setenv("ROS_SECURITY_STRATEGY", "Enforce", 1);
  EXPECT_THROW(rt::Node{"secret"}, std::runtime_error);
  unsetenv("ROS_SECURITY_STRATEGY");
  EXPECT_NO_THROW(rt::Node{"open"});
  unsetenv("ROS_SECURITY_ENABLE");
  setenv("ROS_STATIC_PEERS", "no.such.host.invalid", 1);
  EXPECT_THROW(rt::Node{"seeker"}, std::runtime_error);
  unsetenv("ROS_STATIC_PEERS");
}

// The error message of a node that does not start; empty if it starts.
std::string complaint_at_start() {
  try {
    const rt::Node node{"careful"};
    return {};
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

struct Setting {
  const char* variable;
  const char* value;
  const char* complaint;
};

// Fast DDS logs an error and falls back to its defaults if these are wrong.
TEST(Environment, NothingStartsWhereFastDdsWouldFallBackToDefaults) {
  for (const auto& [variable, value, complaint] :
       {Setting{"ROS_DISCOVERY_SERVER", "127.0.0.1:99999", "'99999' is not a port"},
        Setting{"ROS_DISCOVERY_SERVER", "127.0.0.1:1181x", "'1181x' is not a port"},
        Setting{"ROS_DISCOVERY_SERVER", ";;", "names no server"},
        Setting{"ROS_DISCOVERY_SERVER", "no.such.host.invalid:11811",
                "nor a host name that can be resolved"},
        Setting{"ROS_DISCOVERY_SERVER", "127.0.0.1:11811;a:b:c:d", "is not a locator"},
        Setting{"FASTDDS_ENVIRONMENT_FILE", "/nowhere.json", "no such file"}}) {
    setenv(variable, value, 1);
    const std::string said = complaint_at_start();
    EXPECT_NE(said.find(variable), std::string::npos) << said;
    EXPECT_NE(said.find(complaint), std::string::npos) << said;
    unsetenv(variable);
  }
}

TEST(Environment, TakesWhatFastDdsTakesAsDiscoveryServers) {
  for (const char* servers :
       {"127.0.0.1", "127.0.0.1:11811", ";127.0.0.1:11888", "localhost:11811;127.0.0.1:11812;",
        "[::1]:11811", "UDPv4:[127.0.0.1]:11811", "TCPv4:[127.0.0.1]:42100"})
    EXPECT_NO_THROW(rt::check_discovery_servers(servers)) << servers;
}

// Exits with status 0 if an error names the limit. The limit does not apply to root, so the process
// changes its user.
[[noreturn]] void start_threads_beyond_the_limit() {
  const rlimit limit{1, 1};
  setrlimit(RLIMIT_NPROC, &limit);
  const bool is_limited = getuid() != 0 || setuid(65534) == 0;
  try {
    rt::require_threads(4);
  } catch (const std::runtime_error& error) {
    const bool names_it = std::string{error.what()}.find("ulimit -u") != std::string::npos;
    _exit(is_limited && names_it ? 0 : 1);
  }
  _exit(2);
}

TEST(Environment, ThatGivesTooFewThreadsIsNamed) {
  EXPECT_NO_THROW(rt::require_threads(4));
  EXPECT_EXIT(start_threads_beyond_the_limit(), testing::ExitedWithCode(0), "");
}

// A Fast DDS profile that lets the peer use only one network interface.
class ProfilesFile : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : kVariables) setenv(name, path_.c_str(), 1);
  }
  void TearDown() override {
    for (const char* name : kVariables) unsetenv(name);
    std::remove(path_.c_str());
  }
  void write(const std::string& text) const { std::ofstream{path_} << text; }
  // `limits`: elements of the transport's descriptor.
  void write_profile(const std::string& type, const std::string& limits,
                     bool builtin = false) const {
    std::ofstream{path_}
        << R"(<profiles xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <transport_descriptors><transport_descriptor>
    <transport_id>one</transport_id><type>)"
        << type << "</type>" << limits << R"(
  </transport_descriptor></transport_descriptors>
  <participant profile_name="mine" is_default_profile="true"><rtps>
    <userTransports><transport_id>one</transport_id></userTransports>
    <useBuiltinTransports>)"
        << (builtin ? "true" : "false") << R"(</useBuiltinTransports>
  </rtps></participant>
</profiles>)";
  }
  static std::string only(const std::string& interface) {
    return "<interfaceWhiteList><address>" + interface + "</address></interfaceWhiteList>";
  }
  // By this process, which may have read its own profiles long ago.
  [[nodiscard]] static bool finds_new_peer(double timeout) {
    ChildProcess peer{"peer", {"echo"}};
    rt::Node node{"seeker"};
    const auto ping = node.create_publisher(rt::Topic<Twist>{"ping"});
    return spin_until([&] { return ping.matched() == 1; }, timeout, node);
  }

  static constexpr const char* kVariables[] = {"FASTRTPS_DEFAULT_PROFILES_FILE",
                                               "FASTDDS_DEFAULT_PROFILES_FILE"};

  // A separate file for each test: Fast DDS does not read two files of the same name.
  std::string path_ = testing::TempDir() + "tandem_profiles_" + std::to_string(getpid()) + "_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".xml";
};

TEST_F(ProfilesFile, IsObeyed) {
  write_profile("UDPv4", only("127.0.0.1"));
  EXPECT_TRUE(finds_new_peer(kTimeout));
  write_profile("UDPv4", only("203.0.113.7"));
  EXPECT_FALSE(finds_new_peer(2.0)) << "no such interface here";
  unsetenv(kVariables[0]);
  EXPECT_FALSE(finds_new_peer(2.0)) << "by the newer name";
}

// With its own transports and with those that Fast DDS would add.
TEST_F(ProfilesFile, IsGuardedToo) {
  for (const bool builtin : {false, true}) {
    write_profile("UDPv4", only("127.0.0.1"), builtin);
    ChildProcess peer{"peer", {"echo"}};
    const auto finds_peer = [&] {
      rt::Node node{"seeker"};
      const auto ping = node.create_publisher(rt::Topic<Twist>{"ping"});
      return spin_until([&] { return ping.matched() == 1; }, kTimeout, node);
    };
    ASSERT_TRUE(finds_peer());
    const test::UdpSender stranger;
    for (const auto& file : test::datagram_files("hostile"))
      stranger.send_to_all(test::read(file), 4);
    EXPECT_TRUE(finds_peer());
    peer.send(SIGTERM);
    EXPECT_EQ(peer.wait(kTimeout), 0) << builtin;
  }
}

TEST_F(ProfilesFile, MayNameOtherTransportsThanUdpOnlyIfToldSo) {
  write_profile("SHM", "");
  EXPECT_EQ(ChildProcess("peer", {"echo"}).wait(kTimeout), 1);
  setenv("TANDEM_UNGUARDED_TRANSPORTS", "1", 1);
  ChildProcess peer{"peer", {"echo"}};
  unsetenv("TANDEM_UNGUARDED_TRANSPORTS");
  EXPECT_EQ(peer.wait(0.5), std::nullopt) << "it runs";
  peer.send(SIGTERM);
  EXPECT_EQ(peer.wait(kTimeout), 0);
}

TEST(Environment, LimitsTheSizeOfASample) {
  for (const char* wrong : {"1", "a lot", "-5", "9999999999"}) {
    setenv("TANDEM_MAX_SAMPLE_SIZE", wrong, 1);
    EXPECT_EQ(ChildProcess("peer", {"echo"}).wait(kTimeout), 1) << wrong;
  }
  unsetenv("TANDEM_MAX_SAMPLE_SIZE");
}

TEST_F(ProfilesFile, MayBeNamedByEitherVariable) {
  for (const char* name : kVariables) {
    for (const char* other : kVariables) unsetenv(other);
    setenv(name, path_.c_str(), 1);
    const std::string complaint = complaint_at_start();
    EXPECT_NE(complaint.find(std::string{name} + " = "), std::string::npos) << complaint;
  }
}

TEST_F(ProfilesFile, NothingStartsIfItIsMissingOrBroken) {
  EXPECT_NE(complaint_at_start().find("no such file"), std::string::npos) << complaint_at_start();
  write("<profiles><participant></profiles>");
  EXPECT_NE(complaint_at_start().find("not a valid file of Fast DDS profiles"), std::string::npos)
      << complaint_at_start();
}

// As Jazzy does in range LOCALHOST, the seeker names all addresses of the host as its own.
TEST(TwoProcesses, OfRangeLocalhostReachAPeerOfAllInterfaces) {
  unsetenv("ROS_LOCALHOST_ONLY");
  setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST", 1);
  ChildProcess peer{"peer", {"echo"}};
  setenv("ROS_STATIC_PEERS", "192.0.2.1", 1);
  rt::Node node{"seeker"};
  const auto ping = node.create_publisher(rt::Topic<Twist>{"ping"});
  EXPECT_TRUE(spin_until([&] { return ping.matched() == 1; }, kTimeout, node));
  unsetenv("ROS_STATIC_PEERS");
  unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
  setenv("ROS_LOCALHOST_ONLY", "1", 1);
}

class SignalledPeer : public testing::TestWithParam<int> {};

TEST_P(SignalledPeer, EndsWithStatusZeroWithinASecond) {
  ChildProcess peer{"peer", {"echo"}};
  rt::Node node{"watcher"};
  const auto ping = node.create_publisher(rt::Topic<Twist>{"ping"});
  ASSERT_TRUE(spin_until([&] { return ping.matched() == 1; }, kTimeout, node));
  peer.send(GetParam());
  EXPECT_EQ(peer.wait(1.0), 0);
  EXPECT_TRUE(spin_until([&] { return ping.matched() == 0; }, kTimeout, node));
}

INSTANTIATE_TEST_SUITE_P(Signals, SignalledPeer, testing::Values(SIGINT, SIGTERM, SIGHUP));

TEST(ThrowingCallback, EndsTheProcess) {
  ChildProcess peer{"peer", {"throw"}};
  EXPECT_EQ(peer.wait(kTimeout), 1);
}

}  // namespace
}  // namespace tandem
