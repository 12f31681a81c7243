// SPDX-License-Identifier: Apache-2.0
// Tests that two Tandem processes discover each other through a Fast DDS discovery server alone.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/datagram.hpp"
#include "support/child_process.hpp"
#include "support/nothing_dropped.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "support/udp_sender.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

constexpr const char* kProgram = "/usr/bin/fast-discovery-server";
constexpr double kTimeout = 30.0;  // [s]

// A discovery server as FLEETS.md starts it. Other programs that are started while this object
// exists are its clients.
class Server {
 public:
  explicit Server(bool runs = true) {
    if (runs) start();
    make_clients();
  }
  ~Server() { unsetenv("ROS_DISCOVERY_SERVER"); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] static bool is_installed() { return std::filesystem::exists(kProgram); }
  [[nodiscard]] std::uint16_t port() const { return port_; }

  void start() {
    unsetenv("ROS_DISCOVERY_SERVER");  // a server connects to the servers that it names
    process_.emplace(kProgram, std::vector<std::string>{
                                   "-x", test::source_path("bringup/systems/discovery_server.xml"),
                                   "-i", "0", "-l", "127.0.0.1", "-p", std::to_string(port_)});
    make_clients();
  }
  void kill() {
    process_->send(SIGKILL);
    (void)process_->wait(5.0);
    process_.reset();
  }

 private:
  void make_clients() const {
    setenv("ROS_DISCOVERY_SERVER", ("127.0.0.1:" + std::to_string(port_)).c_str(), 1);
  }

  static inline int servers_ = 0;
  std::uint16_t port_ = static_cast<std::uint16_t>(20'000 + (getpid() + ++servers_) % 10'000);
  std::optional<test::ChildProcess> process_;
};

class Robot {
 private:
  test::ChildProcess process_{
      "../tandem",
      {"run", test::source_path("bringup/systems/teleop.yaml"), "--only", "diff_drive_sim"}};
};

// A node that needs the robot's odometry.
class Listener {
 public:
  [[nodiscard]] rt::Node& node() { return node_; }
  [[nodiscard]] bool hears_the_robot(double max_wait, int messages = 4) {
    heard_ = 0;
    return test::spin_until([&] { return heard_ >= messages; }, max_wait, node_);
  }

 private:
  int heard_ = 0;
  rt::Node node_{"tester"};
  rt::Subscription odom_ = node_.create_subscription(rt::Topic<nav_msgs::msg::Odometry>{"/odom"},
                                                     [this](const auto&) { ++heard_; });
};

class DiscoveryServer : public testing::Test {
 protected:
  void SetUp() override {
    if (!Server::is_installed()) GTEST_SKIP() << "NOT TESTED: " << kProgram << " is not installed";
  }
};

// The node receives odometry of `robot` although neither uses multicast discovery.
TEST_F(DiscoveryServer, BringsOurProcessesTogether) {
  const test::NothingDropped nothing_dropped;
  Server server;
  const Robot robot;
  Listener listener;
  EXPECT_TRUE(listener.hears_the_robot(kTimeout));
  server.kill();  // participants that are already matched no longer need it
  EXPECT_TRUE(listener.hears_the_robot(kTimeout));
}

// A program that comes later meets a robot that the server knew before it died, although the server
// is back long before the robot's lease of the old one (20 s) has ended.
TEST_F(DiscoveryServer, BringsThemTogetherAfterItHasBeenRestarted) {
  Server server;
  const Robot robot;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(Listener{}.hears_the_robot(kTimeout));
  server.kill();
  server.start();
  EXPECT_TRUE(Listener{}.hears_the_robot(12.0)) << "before the lease ends";
}

// A server that can say which announcements it has, but dies before it has announced itself.
class DyingServer {
 public:
  explicit DyingServer(std::uint16_t port)
      : socket_{socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    bound_ = bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~DyingServer() { close(socket_); }
  DyingServer(const DyingServer&) = delete;
  DyingServer& operator=(const DyingServer&) = delete;
  [[nodiscard]] bool bound() const { return bound_; }

  // Tells all clients on this host that of its 100 announcements they need the first one only.
  void announce_little() {
    const test::Octets prefix{0x44, 0x53, 0, 0x5f, 0x45, 0x50, 0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};
    const auto datagram = test::Datagram{}
                              .prefix(prefix)
                              .add_heartbeat(1, 100, count_ + 1, kReader, kWriter)
                              .add_gap(2, 101, 0, kReader, kWriter)
                              .add_heartbeat(1, 100, count_ + 2, kReader, kWriter)
                              .octets();
    count_ += 2;
    for (int participant = 0; participant < 8; ++participant)
      sender_.send(datagram, test::RtpsPorts::discovery(participant));
  }
  // Whether a client has asked for the first announcement, and for no other.
  [[nodiscard]] bool is_believed() {
    std::array<std::uint8_t, 4096> datagram;
    for (;;) {
      const ssize_t size = recv(socket_, datagram.data(), datagram.size(), MSG_DONTWAIT);
      if (size <= 0) return false;
      if (asks_for_the_first({datagram.data(), static_cast<std::size_t>(size)})) return true;
    }
  }

 private:
  static constexpr std::uint32_t kWriter = 0x000100c2, kReader = 0x000100c7;

  // Looks for an ACKNACK, little-endian, of kReader to kWriter with base 1 and one bit.
  static bool asks_for_the_first(std::span<const std::uint8_t> datagram) {
    const test::Octets asked{0, 1, 0, 0xc7, 0, 1, 0, 0xc2, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    return std::search(datagram.begin(), datagram.end(), asked.begin(), asked.end()) !=
           datagram.end();
  }

  int socket_;
  bool bound_;
  std::uint32_t count_ = 0;
  test::UdpSender sender_;
};

// Otherwise the client would take the new server's announcement of the robot for one of the old
// server's that it was told to skip.
TEST_F(DiscoveryServer, BringsThemTogetherAfterOneHasDiedBeforeItAnnouncedItself) {
  Server server{false};
  Listener listener;
  {
    DyingServer dying{server.port()};
    ASSERT_TRUE(dying.bound());
    ASSERT_TRUE(test::spin_until(
        [&] {
          dying.announce_little();
          return dying.is_believed();
        },
        kTimeout, listener.node()));
  }
  server.start();
  const Robot robot;
  EXPECT_TRUE(listener.hears_the_robot(kTimeout));
}

// A server tells its clients only of what they need; `record` needs to know everything.
TEST_F(DiscoveryServer, HidesNothingFromRecord) {
  const Server server;
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("tandem_super_client_" + std::to_string(getpid()));
  const Robot robot;
  test::ChildProcess recorder{"../tandem", {"record", "-o", folder.string(), "/odom"}};
  const auto recorded = [&] {
    std::error_code missing;
    std::uintmax_t size = 0;
    for (const auto& file : std::filesystem::directory_iterator{folder, missing})
      size += file.file_size(missing);
    return size > 20'000;
  };
  rt::Node node{"tester"};
  EXPECT_TRUE(test::spin_until(recorded, kTimeout, node));
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(kTimeout), 0);
  std::filesystem::remove_all(folder);
}

// Counter-check of the first test: without the server the node receives nothing.
TEST_F(DiscoveryServer, IsRequiredByAProcessThatNamesIt) {
  Server server{false};
  const Robot robot;
  Listener listener;
  EXPECT_FALSE(listener.hears_the_robot(3.0, 1));
  server.start();
  EXPECT_TRUE(listener.hears_the_robot(kTimeout)) << "the robot runs";
}

}  // namespace
}  // namespace tandem
