// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using test::spin_until;

using test::kTimeout;
constexpr rt::Topic<Twist> kTwist{"cmd_vel", rt::kDefault};

Twist twist(double v) {
  Twist message;
  message.linear().x(v);
  return message;
}

TEST(Publisher, ReachesASubscriptionOfAnotherNode) {
  rt::Node sender{"sender"}, receiver{"receiver"};
  std::vector<double> got;
  const auto publisher = sender.create_publisher(kTwist);
  const auto subscription =
      receiver.create_subscription(kTwist, [&](const Twist& m) { got.push_back(m.linear().x()); });
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, sender, receiver));
  EXPECT_EQ(subscription.matched(), 1);
  for (int i = 0; i < 5; ++i) publisher.publish(twist(i));
  ASSERT_TRUE(spin_until([&] { return got.size() == 5; }, kTimeout, receiver));
  EXPECT_EQ(got, (std::vector<double>{0, 1, 2, 3, 4}));
}

TEST(Publisher, LatchedMessageReachesALateSubscription) {
  rt::Node node{"latched"};
  constexpr rt::Topic<std_msgs::msg::Bool> kStop{"e_stop", rt::kLatched};
  const auto publisher = node.create_publisher(kStop);
  std_msgs::msg::Bool message;
  message.data(true);
  publisher.publish(message);
  bool got = false;
  const auto subscription = node.create_subscription(kStop, [&](const auto& m) { got = m.data(); });
  EXPECT_TRUE(spin_until([&] { return got; }, kTimeout, node));
}

// Nothing is kept for a later subscription, so nothing is encoded or numbered for nobody.
TEST(Publisher, SendsNothingWithoutASubscriptionUnlessItIsLatched) {
  rt::Node node{"unheard"};
  constexpr rt::Topic<Twist> kKept{"kept", rt::kLatched};
  const auto publisher = node.create_publisher(kTwist);
  const auto latched = node.create_publisher(kKept);
  for (int i = 0; i < 3; ++i) {
    publisher.publish(twist(i));
    latched.publish(twist(i));
  }
  double got = -1.0, kept = -1.0;
  const auto subscription =
      node.create_subscription(kTwist, [&](const Twist& m) { got = m.linear().x(); });
  const auto late = node.create_subscription(kKept, [&](const Twist& m) { kept = m.linear().x(); });
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, node));
  publisher.publish(twist(7.0));
  ASSERT_TRUE(spin_until([&] { return got == 7.0 && kept == 2.0; }, kTimeout, node));
  EXPECT_EQ(subscription.sequence(), 1U);
  EXPECT_EQ(late.sequence(), 3U);
}

TEST(Publisher, ABestEffortSubscriptionReceivesFromAReliablePublisher) {
  rt::Node node{"mixed"};
  int got = 0;
  const auto publisher = node.create_publisher(kTwist);
  const auto subscription =
      node.create_subscription(kTwist, rt::kBestEffort(1), [&](const Twist&) { ++got; });
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, node));
  publisher.publish(twist(1.0));
  EXPECT_TRUE(spin_until([&] { return got == 1; }, kTimeout, node));
}

TEST(Publisher, IsNotMatchedAfterItsSubscriptionIsGone) {
  rt::Node node{"gone"};
  const auto publisher = node.create_publisher(kTwist);
  auto subscription = node.create_subscription(kTwist, [](const Twist&) {});
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, node));
  subscription = {};
  EXPECT_TRUE(spin_until([&] { return publisher.matched() == 0; }, kTimeout, node));
}

TEST(Publisher, CarriesAMapOfManyFragments) {
  rt::Node node{"big"};
  constexpr rt::Topic<octomap_msgs::msg::Octomap> kMap{"octomap_binary", rt::kLatched};
  const auto publisher = node.create_publisher(kMap);
  octomap_msgs::msg::Octomap message;
  message.data().assign(3'000'000, 7);
  std::size_t got = 0;
  const auto subscription =
      node.create_subscription(kMap, [&](const auto& m) { got = m.data().size(); });
  publisher.publish(message);
  ASSERT_TRUE(spin_until([&] { return got > 0; }, kTimeout, node));
  EXPECT_EQ(got, 3'000'000U);
}

TEST(Subscription, MayBeClosedByItsOwnCallback) {
  rt::Node node{"closing"};
  int got = 0;
  const auto publisher = node.create_publisher(kTwist);
  rt::Subscription subscription;
  subscription = node.create_subscription(kTwist, [&](const Twist&) {
    ++got;
    subscription = {};
  });
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, node));
  for (int i = 0; i < 3; ++i) publisher.publish(twist(i));
  ASSERT_TRUE(spin_until([&] { return got > 0; }, kTimeout, node));
  node.spin_some(0.05);
  EXPECT_EQ(got, 1);
}

TEST(Subscription, GetsMoreSamplesThanOneBatch) {
  rt::Node node{"many"};
  constexpr rt::Topic<Twist> kDeep{"deep", {.depth = 100}};
  int got = 0;
  const auto publisher = node.create_publisher(kDeep);
  const auto subscription = node.create_subscription(kDeep, [&](const Twist&) { ++got; });
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, node));
  for (int i = 0; i < 100; ++i) publisher.publish(twist(i));
  EXPECT_TRUE(spin_until([&] { return got == 100; }, kTimeout, node));
}

TEST(Node, RefusesASecondNodeOfItsName) {
  rt::Node node{"twin"};
  EXPECT_THROW(rt::Node{"twin"}, std::exception);
}

TEST(Node, FollowsNamespaceAndRemappings) {
  rt::Node receiver{"plain"};
  rt::Node sender{{.name = "sender", .ns = "/robot", .remappings = {{"cmd_vel", "/wheels"}}}};
  EXPECT_EQ(sender.fully_qualified_name(), "/robot/sender");
  int got = 0;
  const auto wheels =
      receiver.create_subscription(rt::Topic<Twist>{"/wheels"}, [&](const Twist&) { ++got; });
  const auto odom =
      receiver.create_subscription(rt::Topic<Twist>{"robot/odom"}, [&](const Twist&) { ++got; });
  const auto to_wheels = sender.create_publisher(kTwist);
  const auto to_odom = sender.create_publisher(rt::Topic<Twist>{"odom"});
  ASSERT_TRUE(spin_until([&] { return to_wheels.matched() == 1 && to_odom.matched() == 1; },
                         kTimeout, sender, receiver));
  to_wheels.publish(twist(1.0));
  to_odom.publish(twist(1.0));
  EXPECT_TRUE(spin_until([&] { return got == 2; }, kTimeout, receiver));
}

}  // namespace
}  // namespace tandem
