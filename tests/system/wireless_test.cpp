// SPDX-License-Identifier: Apache-2.0
// As faults_test.cpp, but below DDS: the person sits at another computer, and the network between
// it and the robot loses packets, or is gone for a while.
#include <optional>

#include "support/two_hosts.hpp"
#include "system/faulty_system.hpp"

namespace tandem::test {
namespace {

constexpr double kLease = 20.0;  // [s] after which DDS forgets who is silent

// Made before anything that speaks DDS.
struct Network {
  Network() {
    unsetenv("ROS_LOCALHOST_ONLY");
    try {
      hosts.emplace();
    } catch (const std::runtime_error& error) {
      why_not = error.what();
    }
  }
  std::optional<TwoHosts> hosts;
  std::string why_not;
};

// The robot here, the person (driver and teleop) there.
class WirelessSystem : public Network, public WatchedSystem {
 public:
  WirelessSystem() {
    if (!hosts) return;
    for (const std::string name : kComponents) {
      if (name != "driver" && name != "teleop")
        start(name);
      else
        person_.push_back(std::make_unique<ChildProcess>(
            "/bin/ip",
            hosts->on_second({TANDEM_BINARY_DIR "/tandem", "run", system(), "--only", name})));
    }
  }

 private:
  std::vector<std::unique_ptr<ChildProcess>> person_;
};

class Wireless : public FaultTest<WirelessSystem> {
 protected:
  void SetUp() override {
    if (!system_.hosts) GTEST_SKIP() << "NOT TESTED: no two hosts here: " << system_.why_not;
  }
  [[nodiscard]] std::function<void()> losing(int percent) const {
    return [this, percent] { system_.hosts->lose(percent); };
  }
};

TEST_F(Wireless, LosesPackets) {
  const auto none = losing(0);
  std::vector<Fault> faults;
  for (const int percent : {10, 30, 50})
    faults.push_back({std::to_string(percent) + " % of all packets lost, each way", losing(percent),
                      none, nullptr, false, kZeroWithin, 5.0});
  faults.push_back({"network gone", losing(100), none, "cmd_vel_user is silent"});
  faults.push_back({"network gone for so long that DDS forgets the other", losing(100), none,
                    "cmd_vel_user is silent", true, kZeroWithin, kLease + 3.0});
  suffer(faults);
}

}  // namespace
}  // namespace tandem::test
