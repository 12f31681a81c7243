// SPDX-License-Identifier: Apache-2.0
// A device that publishes five times a second, as a slow radio link or a script may. With timeouts
// raised to fit, the robot drives through the forest as with a fast device; with the default
// timeouts it stops each time and reports why.
#include "system/faulty_system.hpp"

namespace tandem::test {
namespace {

const char* const kTooSlow = "cmd_vel_user is silent";

class SlowUser : public ::testing::Test {
 protected:
  SlowUser() {
    joy_ = system_.node().create_subscription(topics::joy, [this](const auto& msg) {
      held_ = !msg.buttons().empty() && msg.buttons()[0] == 1;
      ++samples_;
    });
    // What the safety filter makes of it, on a machine that is late, is not what is asked here.
    asked_ =
        system_.node().create_subscription(topics::cmd_vel_arbitrated, [this](const auto& msg) {
          const auto twist = from_msg(msg);
          stutters_ += held_ && twist == Twist2{} ? 1 : 0;
        });
  }
  void start(const std::vector<std::string>& ros_args) {
    for (const std::string name : kComponents) system_.start(name, ros_args);
  }
  [[nodiscard]] static std::vector<std::string> parameters(
      const std::vector<std::string>& assignments) {
    std::vector<std::string> arguments{"--ros-args"};
    for (const auto& assignment : assignments) {
      arguments.emplace_back("-p");
      arguments.push_back(assignment);
    }
    return arguments;
  }

  WatchedSystem system_;
  rt::Subscription joy_, asked_;
  bool held_ = false;
  int samples_ = 0, stutters_ = 0;
};

TEST_F(SlowUser, DrivesWithoutStutterIfTheTimeOutsAllowForIt) {
  start(parameters({"driver:rate:=5.0", "teleop:joy_timeout:=0.5", "arbitration:user_timeout:=0.5",
                    "local_planner:user_timeout:=0.5",
                    // On a busy machine these too are late, and are not what is asked here.
                    "arbitration:shared_timeout:=0.5", "local_planner:obstacle_timeout:=0.5"}));
  ASSERT_TRUE(system_.wait_until_driving());
  system_.forget();
  const double began = system_.sim_time;
  const int before = samples_;
  stutters_ = 0;
  EXPECT_TRUE(system_.wait_until([&] { return system_.sim_time > began + 4.0; }, 10.0));
  EXPECT_EQ(stutters_, 0) << system_.sayings();
  EXPECT_FALSE(system_.heard_any(kTooSlow)) << system_.sayings();
  EXPECT_NEAR((samples_ - before) / (system_.sim_time - began), 5.0, 1.0);
  EXPECT_EQ(system_.collisions, 0U);
}

TEST_F(SlowUser, StopsAndSaysWhyByDefault) {
  start(parameters({"driver:rate:=5.0"}));
  bool drove = false;
  EXPECT_TRUE(system_.wait_until(
      [&] {
        if (!drove) system_.forget();
        drove = drove || system_.command.v > 0.02;
        return drove && system_.command == Twist2{} && system_.said(kTooSlow, Told::kOnBoth);
      },
      40.0))
      << system_.sayings();
  EXPECT_EQ(system_.collisions, 0U);
}

}  // namespace
}  // namespace tandem::test
