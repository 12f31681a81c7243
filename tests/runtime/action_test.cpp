// SPDX-License-Identifier: Apache-2.0
// Action servers and clients of ours with each other; with rclpy's: tests/interop/rclpy.
#include <gtest/gtest.h>

#include <optional>
#include <test_msgs/messages.hpp>
#include <vector>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/action_client.hpp"
#include "tandem/runtime/action_server.hpp"

namespace tandem {
namespace {

using rt::CancelAnswer;
using rt::GoalReply;
using rt::GoalStatus;
using test::kTimeout;
using test::spin_until;
using test_msgs::action::Fibonacci;

constexpr rt::ActionName<Fibonacci> kAction{"fibonacci"};

Fibonacci::Goal order(int value) {
  Fibonacci::Goal goal;
  goal.order(value);
  return goal;
}

Fibonacci::Result sequence(std::vector<std::int32_t> numbers) {
  Fibonacci::Result result;
  result.sequence(std::move(numbers));
  return result;
}

// A server that accepts what is not negative and leaves the goals to the test.
class Server {
 public:
  explicit Server(double result_timeout = rt::kResultTimeout)
      : server_{node.create_action_server(
            kAction,
            {.on_goal =
                 [](const auto& goal) {
                   return goal.order() < 0 ? rt::GoalAnswer::kReject : rt::GoalAnswer::kExecute;
                 },
             .on_cancel = [this](const auto&) { return agrees_to_cancel; },
             .on_accepted = [this](const auto& goal) { goals.push_back(goal); }},
            result_timeout)} {}

  rt::Node node{"server"};
  bool agrees_to_cancel = true;
  std::vector<rt::ServerGoal<Fibonacci>> goals;

 private:
  rt::ActionServer<Fibonacci> server_;
};

// A client that sends one goal at a time and keeps what it is told about it.
class Client {
 public:
  explicit Client(const std::string& name = "client") : node{name} {}

  void send(int value, double timeout = kTimeout) {
    reply.reset();
    ended.reset();
    id = client.send(order(value),
                     {.on_reply = [this](GoalReply told) { reply = told; },
                      .on_feedback = [this](const auto& told) { feedback = told.sequence(); },
                      .on_result =
                          [this](GoalStatus status, const auto& told) {
                            ended = status;
                            result = told.sequence();
                          }},
                     timeout);
  }

  rt::Node node;
  rt::ActionClient<Fibonacci> client = node.create_action_client(kAction);
  rt::GoalId id{};
  std::optional<GoalReply> reply;
  std::optional<GoalStatus> ended;
  std::vector<std::int32_t> feedback, result;
};

class Action : public testing::Test {
 protected:
  template <class Predicate>
  [[nodiscard]] bool until(Predicate predicate) {
    return spin_until(predicate, kTimeout, server_->node, client_.node);
  }
  void begin() {
    client_.send(5);
    ASSERT_TRUE(until([&] { return client_.reply && !server_->goals.empty(); }));
    ASSERT_EQ(client_.reply, GoalReply::kAccepted);
  }
  CancelAnswer cancel() {
    std::optional<CancelAnswer> answer;
    client_.client.cancel(
        client_.id, [&](CancelAnswer told) { answer = told; }, kTimeout);
    EXPECT_TRUE(until([&] { return answer.has_value(); }));
    return answer.value_or(CancelAnswer::kUnknown);
  }

  std::optional<Server> server_{std::in_place};
  Client client_;
};

TEST_F(Action, TakesAGoalToItsResultWithFeedback) {
  begin();
  const auto& goal = server_->goals.front();
  EXPECT_EQ(goal.goal().order(), 5);
  EXPECT_EQ(goal.id(), client_.id);
  EXPECT_EQ(goal.status(), GoalStatus::kExecuting);
  Fibonacci::Feedback feedback;
  feedback.sequence({0, 1});
  ASSERT_TRUE(until([&] {
    goal.publish_feedback(feedback);
    return client_.feedback.size() == 2;
  }));
  ASSERT_TRUE(until([&] { return client_.client.status(client_.id) == GoalStatus::kExecuting; }));
  goal.succeed(sequence({0, 1, 1}));
  ASSERT_TRUE(until([&] { return client_.ended.has_value(); }));
  EXPECT_EQ(client_.ended, GoalStatus::kSucceeded);
  EXPECT_EQ(client_.result, (std::vector<std::int32_t>{0, 1, 1}));
  EXPECT_FALSE(goal.is_active());
}

TEST_F(Action, RejectsAGoal) {
  client_.send(-1);
  ASSERT_TRUE(until([&] { return client_.reply.has_value(); }));
  EXPECT_EQ(client_.reply, GoalReply::kRejected);
  EXPECT_TRUE(server_->goals.empty());
}

TEST_F(Action, IsCancelledIfTheServerAgrees) {
  begin();
  server_->agrees_to_cancel = false;
  EXPECT_EQ(cancel(), CancelAnswer::kRejected);
  EXPECT_FALSE(server_->goals.front().is_canceling());
  server_->agrees_to_cancel = true;
  EXPECT_EQ(cancel(), CancelAnswer::kNone);
  EXPECT_TRUE(server_->goals.front().is_canceling());
  server_->goals.front().canceled({});
  ASSERT_TRUE(until([&] { return client_.ended.has_value(); }));
  EXPECT_EQ(client_.ended, GoalStatus::kCanceled);
  EXPECT_EQ(cancel(), CancelAnswer::kTerminated);
}

TEST_F(Action, KeepsTwoClientsApart) {
  Client other{"other"};
  client_.send(1);
  other.send(2);
  ASSERT_TRUE(spin_until([&] { return server_->goals.size() == 2; }, kTimeout, server_->node,
                         client_.node, other.node));
  for (const auto& goal : server_->goals) goal.succeed(sequence({goal.goal().order()}));
  ASSERT_TRUE(spin_until([&] { return client_.ended && other.ended; }, kTimeout, server_->node,
                         client_.node, other.node));
  EXPECT_EQ(client_.result.front(), 1);
  EXPECT_EQ(other.result.front(), 2);
}

TEST_F(Action, GoesOnWithoutItsClient) {
  begin();
  EXPECT_TRUE(server_->goals.front().has_client());
  client_.client = {};
  const auto& goal = server_->goals.front();
  ASSERT_TRUE(until([&] { return !goal.has_client(); }));
  EXPECT_TRUE(goal.is_active());
  goal.succeed({});
  EXPECT_EQ(goal.status(), GoalStatus::kSucceeded);
}

TEST_F(Action, IsLostWithItsServer) {
  begin();
  server_.reset();
  ASSERT_TRUE(spin_until([&] { return client_.ended.has_value(); }, kTimeout, client_.node));
  EXPECT_EQ(client_.ended, GoalStatus::kUnknown);
}

TEST_F(Action, IsLostWithItsServerEvenIfAnotherTakesItsPlace) {
  begin();
  ASSERT_TRUE(until([&] { return client_.client.status(client_.id) == GoalStatus::kExecuting; }));
  server_.reset();
  server_.emplace();
  ASSERT_TRUE(until([&] { return client_.ended.has_value(); }));
  EXPECT_EQ(client_.ended, GoalStatus::kUnknown);
  client_.send(3);
  ASSERT_TRUE(until([&] { return !server_->goals.empty(); }));
  server_->goals.front().succeed({});
  ASSERT_TRUE(until([&] { return client_.ended.has_value(); }));
  EXPECT_EQ(client_.ended, GoalStatus::kSucceeded);
}

TEST_F(Action, HasNoAnswerWithoutAServer) {
  server_.reset();
  client_.send(5, 0.05);
  ASSERT_TRUE(spin_until([&] { return client_.reply.has_value(); }, kTimeout, client_.node));
  EXPECT_EQ(client_.reply, GoalReply::kNoAnswer);
}

TEST_F(Action, PublishesItsStatusToLateSubscribers) {
  begin();
  std::vector<action_msgs::msg::GoalStatus> listed;
  rt::Node late{"late"};
  const auto status = late.create_subscription(
      rt::Topic<action_msgs::msg::GoalStatusArray>{"fibonacci/_action/status", rt::kActionStatus},
      [&](const auto& message) { listed = message.status_list(); });
  ASSERT_TRUE(
      spin_until([&] { return listed.size() == 1; }, kTimeout, server_->node, late, client_.node));
  EXPECT_EQ(listed.front().status(), 2);
  EXPECT_EQ(listed.front().goal_info().goal_id().uuid(), client_.id);
}

// Asks for results by the service alone.
class Results : public Action {
 protected:
  GoalStatus ask(const rt::GoalId& id) {
    Fibonacci::GetResult::Request request;
    request.goal_id(rt::to_msg(id));
    std::optional<GoalStatus> status;
    service_.call(
        request, [&](const auto& response) { status = static_cast<GoalStatus>(response.status()); },
        kTimeout);
    EXPECT_TRUE(until([&] { return status.has_value(); }));
    return status.value_or(GoalStatus::kExecuting);
  }
  rt::Client<Fibonacci::GetResult> service_ = client_.node.create_client(
      rt::ServiceName<Fibonacci::GetResult>{"fibonacci/_action/get_result"});
};

TEST_F(Results, AreReturnedUntilTheyAreForgotten) {
  server_.emplace(0.0);
  begin();
  server_->goals.front().succeed({});
  EXPECT_EQ(ask(rt::make_goal_id()), GoalStatus::kUnknown);
  ASSERT_TRUE(until([&] { return server_->goals.front().status() == GoalStatus::kUnknown; }));
  EXPECT_EQ(ask(client_.id), GoalStatus::kUnknown);
}

TEST_F(Results, AreReturnedAgain) {
  begin();
  server_->goals.front().abort({});
  EXPECT_EQ(ask(client_.id), GoalStatus::kAborted);
  EXPECT_EQ(ask(client_.id), GoalStatus::kAborted);
}

}  // namespace
}  // namespace tandem
