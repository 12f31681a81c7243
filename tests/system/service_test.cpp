// SPDX-License-Identifier: Apache-2.0
// The command of the systemd unit, started as systemd starts it.
#include <sys/socket.h>
#include <sys/un.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

// The socket on which systemd receives the reports of a service.
class NotifySocket {
 public:
  NotifySocket() : file_{socket(AF_UNIX, SOCK_DGRAM, 0)} {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    fs::remove(path_);
    if (bind(file_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("cannot bind " + path_);
    setenv("NOTIFY_SOCKET", path_.c_str(), 1);
  }
  ~NotifySocket() {
    unsetenv("NOTIFY_SOCKET");
    close(file_);
    fs::remove(path_);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  // The next report; empty if none arrives within `timeout` [s].
  std::string next(int timeout) const {
    const timeval wait{timeout, 0};
    setsockopt(file_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
    char text[100];
    const auto size = recv(file_, text, sizeof text, 0);
    return {text, size > 0 ? static_cast<std::size_t>(size) : 0};
  }

 private:
  int file_;
  std::string path_ = "/tmp/tandem_service_test_" + std::to_string(getpid());
};

// The words after the program in the unit's ExecStart, for a system.
std::vector<std::string> words_of_unit(const std::string& system) {
  std::ifstream unit{source_path("bringup/debian/tandem@.service")};
  for (std::string line; std::getline(unit, line);) {
    std::istringstream text{line};
    std::vector<std::string> words;
    for (std::string word; text >> word;) words.push_back(word == "%i" ? system : word);
    if (words.empty() || !words.front().starts_with("ExecStart=")) continue;
    words.erase(words.begin());
    return words;
  }
  return {};
}

ChildProcess start_service(const std::string& system, const std::string& component) {
  auto words = words_of_unit(system);
  words.insert(words.begin() + 2, {"--only", component});
  return {"../tandem", words};
}

TEST(Service, ReportsThatItIsReadyAndAlive) {
  const NotifySocket socket;
  const auto service = start_service(source_path("bringup/systems/forest.yaml"), "arbitration");
  EXPECT_EQ(socket.next(20), "READY=1");
  EXPECT_EQ(socket.next(20), "WATCHDOG=1");
  EXPECT_EQ(socket.next(20), "WATCHDOG=1");
  service.send(SIGTERM);
  std::string last;
  while (last != "STOPPING=1") ASSERT_FALSE((last = socket.next(20)).empty());
}

// The simulated person holds the stick throughout.
TEST(Service, StartedAfterACrashTheRobotStandsByEmergencyStop) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  system.kill_hard("arbitration");
  ASSERT_TRUE(system.wait_until([&] { return system.stands(); }, 5.0));
  const auto service = start_service(system.system(), "arbitration");
  ASSERT_TRUE(system.wait_until([&] { return system.reason == Reason::kEmergencyStop; }, 20.0));

  const Pose2 there = system.truth.X;
  const double stood_at = system.sim_time;
  const auto release = system.node().create_client(
      rt::ServiceName<std_srvs::srv::Trigger>{"arbitration/release_emergency_stop"});
  std::optional<bool> released;
  release.call({}, [&](const auto& response) { released = response.success(); });
  EXPECT_TRUE(
      system.wait_until([&] { return released && system.sim_time > stood_at + 3.0; }, 20.0));
  EXPECT_FALSE(released.value_or(true)) << "nobody withdrew the stop";
  EXPECT_EQ(system.reason, Reason::kEmergencyStop);
  EXPECT_LT((system.truth.X.position() - there.position()).norm(), 0.01);
}

}  // namespace
}  // namespace tandem::test
