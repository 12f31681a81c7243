// SPDX-License-Identifier: Apache-2.0
#include "dashboard/autonomy_guard.hpp"

#include <gtest/gtest.h>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "topics.hpp"

namespace tandem {
namespace {

using tandem_msgs::srv::SetPolicy;

constexpr double kTimeout = 10.0;  // [s]
constexpr ClientId kFirst = 1, kSecond = 2;

// A dashboard's guard beside an arbitration that this test plays.
class AutonomyGuardOverDds : public testing::Test {
 protected:
  void let_drive_itself(ClientId client) {
    SetPolicy::Request request;
    request.policy("autonomous");
    guard_.on_call(client, "/arbitration/set_policy", rt::encode(request));
  }
  void hear(const std::string& policy) {
    tandem_msgs::msg::ArbitrationStatus status;
    status.policy(policy);
    ASSERT_TRUE(test::spin_until([&] { return status_.matched() > 0; }, kTimeout, arbitration_,
                                 dashboard_));
    status_.publish(status);
    // Heard by us as late as by the guard.
    ASSERT_TRUE(
        test::spin_until([&] { return heard_ == policy; }, kTimeout, arbitration_, dashboard_));
  }
  [[nodiscard]] bool asked_for(const std::vector<std::string>& policies) {
    return test::spin_until([&] { return policies_ == policies; }, kTimeout, arbitration_,
                            dashboard_);
  }

 private:
  rt::Node arbitration_{"arbitration"}, dashboard_{"dashboard"};
  std::vector<std::string> policies_;
  std::string heard_;
  rt::Service service_ = arbitration_.create_service(
      rt::ServiceName<SetPolicy>{"arbitration/set_policy"},
      [this](const auto& request, auto&) { policies_.push_back(request.policy()); });
  rt::Publisher<tandem_msgs::msg::ArbitrationStatus> status_ =
      arbitration_.create_publisher(topics::arbitration_status);

 protected:
  AutonomyGuard guard_{dashboard_};

 private:
  rt::Subscription on_status_ = dashboard_.create_subscription(
      topics::arbitration_status, [this](const auto& msg) { heard_ = msg.policy(); });
};

TEST_F(AutonomyGuardOverDds, EndsItWhenTheClientThatLetItIsGone) {
  let_drive_itself(kFirst);
  hear("autonomous");
  guard_.on_leave(kSecond);
  guard_.on_leave(kFirst);
  EXPECT_TRUE(asked_for({"shared"}));
}

TEST_F(AutonomyGuardOverDds, EndsItThoughTheStatusOfBeforeIsHeardAfterTheCall) {
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
  EXPECT_EQ(log.lines("is gone: policy shared"), 0);
  let_drive_itself(kSecond);
  guard_.on_leave(kSecond);
  EXPECT_EQ(log.lines("is gone: policy shared"), 1);
  EXPECT_TRUE(asked_for({"shared"}));
}

}  // namespace
}  // namespace tandem
