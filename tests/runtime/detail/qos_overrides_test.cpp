// SPDX-License-Identifier: Apache-2.0
// Tests setting a topic's QoS by parameters with rclcpp's names.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

constexpr rt::Topic<geometry_msgs::msg::Twist> kCommand{"cmd_vel"};

rt::NodeOptions with(std::map<std::string, std::string> values) {
  rt::NodeOptions options{.name = "tuned", .ns = "/chair"};
  for (auto& [key, value] : values) options.parameters.values[key] = {value, "test"};
  return options;
}

rt::TopicInfo info_of(const rt::Node& node, const std::string& topic) {
  for (const auto& info : node.topics())
    if (info.name == topic) return info;
  return {};
}

TEST(QosOverrides, ChangeWhatANodeOffersAndRequests) {
  rt::Node node{with({{"qos_overrides./chair/cmd_vel.publisher.reliability", "best_effort"},
                      {"qos_overrides./chair/cmd_vel.subscription.durability", "transient_local"},
                      {"qos_overrides./chair/cmd_vel.subscription.depth", "3"}})};
  const auto publisher = node.create_publisher(kCommand);
  const auto subscription = node.create_subscription(kCommand, [](const auto&) {});
  const auto info = info_of(node, "/chair/cmd_vel");
  ASSERT_EQ(info.publishers.size(), 1U);
  EXPECT_EQ(info.publishers[0].reliability, 0);
  EXPECT_EQ(info.publishers[0].durability, 0);
  ASSERT_EQ(info.subscriptions.size(), 1U);
  EXPECT_EQ(info.subscriptions[0].reliability, 1);
  EXPECT_EQ(info.subscriptions[0].durability, 1);
  EXPECT_NO_THROW(node.check_parameters());
}

// Twist and TwistStamped under one name, and latched publishers next to volatile ones.
TEST(QosOverrides, HoldForEverySubscriptionButForItsOtherDurability) {
  rt::Node node{with({{"qos_overrides./chair/cmd_vel.subscription.reliability", "best_effort"},
                      {"qos_overrides./chair/cmd_vel.subscription.durability", "volatile"}})};
  const auto first = node.create_subscription(kCommand, [](const auto&) {});
  const auto second = node.create_subscription(
      rt::Topic<geometry_msgs::msg::TwistStamped>{"cmd_vel"}, [](const auto&) {});
  const auto latched = node.create_subscription(kCommand, rt::kLatched, [](const auto&) {});
  std::vector<rt::Policies> all;
  ASSERT_TRUE(test::spin_until(
      [&] {
        all.clear();
        for (const auto& info : node.topics())
          if (info.name == "/chair/cmd_vel")
            all.insert(all.end(), info.subscriptions.begin(), info.subscriptions.end());
        return all.size() == 3;
      },
      10.0, node));
  int durable = 0;
  for (const auto& policies : all) {
    EXPECT_EQ(policies.reliability, 0);
    durable += policies.durability;
  }
  EXPECT_EQ(durable, 1);
}

// As the emergency stop has it; `ros2 param dump` gives each value of the first subscription.
TEST(QosOverrides, ThatRepeatTheTopicsOwnQosLeaveEachSubscriptionItsOwn) {
  const std::string prefix = "qos_overrides./chair/cmd_vel.subscription.";
  rt::Node node{with({{prefix + "reliability", "reliable"},
                      {prefix + "durability", "volatile"},
                      {prefix + "depth", "10"},
                      {prefix + "history", "keep_last"}})};
  const auto strong = node.create_subscription(kCommand, [](const auto&) {});
  const auto weak = node.create_subscription(kCommand, rt::kBestEffort(1), [](const auto&) {});
  const auto info = info_of(node, "/chair/cmd_vel");
  ASSERT_EQ(info.subscriptions.size(), 2U);
  EXPECT_EQ(info.subscriptions[0].reliability + info.subscriptions[1].reliability, 1);
}

TEST(QosOverrides, AreParametersWhetherGivenOrNot) {
  rt::Node node{with({})};
  const auto publisher = node.create_publisher(kCommand);
  std::map<std::string, std::string> listed;
  for (const auto& parameter : node.core()->parameters.all())
    listed[parameter.name()] = rt::to_text(parameter.value());
  const std::string prefix = "qos_overrides./chair/cmd_vel.publisher.";
  EXPECT_EQ(listed[prefix + "reliability"], "\"reliable\"");
  EXPECT_EQ(listed[prefix + "durability"], "\"volatile\"");
  EXPECT_EQ(listed[prefix + "history"], "\"keep_last\"");
  EXPECT_EQ(listed[prefix + "depth"], "10");
}

TEST(QosOverrides, ForAnUnopenedTopicAreRefused) {
  rt::Node node{with({{"qos_overrides./nobody.publisher.depth", "3"}})};
  EXPECT_THROW(node.check_parameters(), std::invalid_argument);
}

TEST(QosOverrides, AreRefusedIfInvalid) {
  rt::Node node{with({{"qos_overrides./chair/cmd_vel.publisher.reliability", "perhaps"}})};
  try {
    const auto publisher = node.create_publisher(kCommand);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string{error.what()}.find("not one of {reliable, best_effort}"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace tandem
