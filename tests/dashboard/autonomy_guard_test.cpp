// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/autonomy_guard.hpp"

#include <gtest/gtest.h>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

using tandem_msgs::srv::SetPolicy;

constexpr double kTimeout = 10.0;  // [s]
constexpr ClientId kFirst = 1, kSecond = 2;

// A dashboard's guard beside an arbitration that this test plays.
class AutonomyGuardOverDds : public testing::Test {
 protected:
  void call(ClientId client, const std::string& robot, const std::string& policy) {
    SetPolicy::Request request;
    request.policy(policy);
    guard_.on_call(client, robot + "/arbitration/set_policy", rt::encode(request));
  }
  void let_drive_itself(ClientId client) { call(client, "", "autonomous"); }
  void hear(const std::string& policy) {
    tandem_msgs::msg::ArbitrationStatus status;
    status.policy(policy);
    ASSERT_TRUE(test::spin_until([&] { return status_.matched() > 0; }, kTimeout, arbitration_,
                                 dashboard_));
    status_.publish(status);
    // Stamped by us as late as by the guard.
    ASSERT_TRUE(
        test::spin_until([&] { return heard_ == policy; }, kTimeout, arbitration_, dashboard_));
  }
  using Policies = std::vector<std::string>;
  [[nodiscard]] bool asked_for(const Policies& policies, const Policies& others = {}) {
    return test::spin_until([&] { return policies_ == policies && others_ == others; }, kTimeout,
                            arbitration_, other_, dashboard_);
  }

 private:
  static rt::Service play(rt::Node& node, Policies& asked) {
    return node.create_service(
        rt::ServiceName<SetPolicy>{"~/set_policy"},
        [&asked](const auto& request, auto&) { asked.push_back(request.policy()); });
  }

  rt::Node arbitration_{"arbitration"}, dashboard_{"dashboard"};
  rt::Node other_{rt::NodeOptions{.name = "arbitration", .ns = "/b"}};
  Policies policies_, others_;
  std::string heard_;
  rt::Service service_ = play(arbitration_, policies_), others_service_ = play(other_, others_);
  rt::Publisher<tandem_msgs::msg::ArbitrationStatus> status_ =
      arbitration_.create_publisher(topics::arbitration_status);

 protected:
  AutonomyGuard guard_{dashboard_};

 private:
  rt::Subscription on_status_ = dashboard_.create_subscription(
      topics::arbitration_status, [this](const auto& msg) { heard_ = msg.policy(); });
};

TEST_F(AutonomyGuardOverDds, EndsItWhenTheClientThatStartedItDisconnects) {
  let_drive_itself(kFirst);
  hear("autonomous");
  guard_.on_leave(kSecond);
  guard_.on_leave(kFirst);
  EXPECT_TRUE(asked_for({"shared"}));
}

TEST_F(AutonomyGuardOverDds, EndsItEvenIfAnEarlierStatusArrivesAfterTheCall) {
  let_drive_itself(kFirst);
  hear("manual");
  guard_.on_leave(kFirst);
  EXPECT_TRUE(asked_for({"shared"}));
}

TEST_F(AutonomyGuardOverDds, LeavesThePolicyThatAnotherNodeSetSince) {
  const test::CapturedLog log;
  let_drive_itself(kFirst);
  hear("autonomous");
  hear("manual");
  guard_.on_leave(kFirst);
  EXPECT_EQ(log.lines("policy set to shared"), 0);
  let_drive_itself(kSecond);
  guard_.on_leave(kSecond);
  EXPECT_EQ(log.lines("policy set to shared"), 1);
  EXPECT_TRUE(asked_for({"shared"}));
}

TEST_F(AutonomyGuardOverDds, TreatsRobotsSeparately) {
  let_drive_itself(kFirst);
  call(kSecond, "/b", "manual");
  guard_.on_leave(kFirst);
  EXPECT_TRUE(asked_for({"shared"}));
  call(kSecond, "/b", "autonomous");
  call(kFirst, "", "manual");
  guard_.on_leave(kSecond);
  EXPECT_TRUE(asked_for({"shared"}, {"shared"}));
}

}  // namespace
}  // namespace tandem
