// SPDX-License-Identifier: Apache-2.0
// Like faults_test.cpp, but below DDS: the person uses another computer, and the network between it
// and the robot loses packets or fails for a while.
#include <optional>

#include "support/paths.hpp"
#include "support/two_hosts.hpp"
#include "system/faulty_system.hpp"

namespace tandem::test {
namespace {

// [s] real time after which DDS drops a participant that sends nothing
constexpr double kLease = 20.0;

// Must be constructed before any DDS participant.
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

// The robot runs on this host; the person's nodes (driver and teleop) on the other.
class WirelessSystem : public Network, public WatchedSystem {
 public:
  WirelessSystem() {
    if (!hosts) return;
    for (const std::string name : kComponents) {
      if (name != "driver" && name != "teleop")
        start(name);
      else
        person_[name] = std::make_unique<ChildProcess>(
            "/bin/ip", hosts->on_second({binary_path("tandem"), "run", system(), "--only", name}));
    }
  }

  /// A process on the other host.
  [[nodiscard]] ChildProcess& person(const std::string& name) { return *person_.at(name); }

 private:
  std::map<std::string, std::unique_ptr<ChildProcess>> person_;
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
    faults.push_back(
        {std::to_string(percent) + " % of all packets lost, each way", losing(percent), none});
  for (auto& fault : faults) fault.lasts = 5.0 * kSpeed;
  Fault gone{"network gone", losing(100), none, "cmd_vel_user is silent"};
  faults.push_back(gone);
  gone.name += " for so long that DDS forgets the other";
  gone.lasts = kSpeed * (kLease + 3.0);
  faults.push_back(gone);
  suffer(faults);
}

// A driver who releases the stick during a network outage wants the robot to stand when the network
// returns, whatever was sent last before and whatever is queued for retransmission.
TEST_F(Wireless, NoOldCommandComesBackWithTheNetwork) {
  ASSERT_TRUE(system_.wait_until_driving());
  system_.hosts->lose(100);
  ASSERT_TRUE(system_.wait_until([&] { return !system_.deadman && system_.stands(); }, 5.0));
  system_.person("driver").send(SIGSTOP);
  const double let_go = system_.sim_time;
  ASSERT_TRUE(system_.wait_until([&] { return system_.sim_time > let_go + 1.0; }, 10.0));
  const double back = system_.sim_time;
  system_.hosts->lose(0);
  bool moved = false;
  EXPECT_TRUE(system_.wait_until(
      [&] {
        moved = moved || !system_.stands() || !(system_.command == Twist2{});
        return system_.sim_time > back + kLasts;
      },
      kLasts + 10.0));
  EXPECT_FALSE(moved) << "command " << system_.command.v << " m/s, " << system_.command.w
                      << " rad/s; moves at " << system_.truth.twist.v;
  system_.person("driver").send(SIGCONT);
  EXPECT_TRUE(system_.wait_until_driving()) << "does not drive on";
  EXPECT_EQ(system_.collisions, 0U);
}

}  // namespace
}  // namespace tandem::test
