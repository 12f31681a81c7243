// SPDX-License-Identifier: Apache-2.0
// Messages that may wait until their node is awake.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>

#include "support/child_process.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

class Patience : public ::testing::Test {
 protected:
  using Twist = geometry_msgs::msg::Twist;
  static constexpr rt::Topic<Twist> kPing{"ping"}, kPong{"pong"};
  static constexpr double kPatience = 0.2;   // [s]
  static constexpr double kRounding = 1e-6;  // [s]

  rt::Subscription hear(const rt::QoS& qos, double patience) {
    auto subscription = node_.create_subscription(kPong, qos, [this](const Twist&) {
      ++heard_;
      arrival_ = node_.now();
    });
    subscription.may_wait(patience);
    return subscription;
  }

  // Sleeps until that many messages have arrived. Unlike spin_until(), it does not wake the
  // node.
  bool hears(int messages) {
    const double end = node_.now() + test::kTimeout;
    while (heard_ < messages && node_.now() < end) node_.spin_some(test::kTimeout);
    return heard_ == messages;
  }

  rt::Node node_{"patience"};
  int heard_ = 0;
  double arrival_ = 0.0;  // of the last message, by the node's clock [s]
};

// The node may be awake for something else in one of the rounds.
TEST_F(Patience, AMessageDoesNotWakeItsNodeAndKnowsWhenItArrived) {
  const auto publisher = node_.create_publisher(kPong);
  const auto subscription = hear(rt::kDefault, kPatience);
  double longest = 0.0, least_error = test::kTimeout;  // [s]; the thread may be interrupted
  for (int round = 1; round <= 5; ++round) {
    node_.spin_some(0.0);
    const double before = node_.now();
    publisher.publish({});
    const double after = node_.now();
    ASSERT_TRUE(hears(round));
    EXPECT_GE(arrival_, before - kRounding);
    least_error = std::min(least_error, arrival_ - after);
    longest = std::max(longest, node_.now() - after);
  }
  EXPECT_GT(longest, kPatience / 4);
  EXPECT_LT(least_error, 0.001);
}

TEST_F(Patience, OneFromAnotherProcessKnowsWhenItArrived) {
  const test::ChildProcess peer{"peer", {"echo"}};
  const auto publisher = node_.create_publisher(kPing);
  const auto subscription = hear(rt::kLatched, kPatience);
  ASSERT_TRUE(
      test::spin_until([&] { return publisher.matched() == 1 && subscription.matched() == 1; },
                       test::kTimeout, node_));
  double longest = 0.0;
  for (int round = 1; round <= 5; ++round) {
    node_.spin_some(0.0);
    const double before = node_.now();
    publisher.publish({});
    ASSERT_TRUE(hears(round));
    EXPECT_GT(arrival_, before);
    longest = std::max(longest, node_.now() - arrival_);
  }
  EXPECT_GT(longest, kPatience / 4);
}

TEST_F(Patience, AMessageFromBeforeAJumpOfTheTimeIsDropped) {
  const rt::Topic<rosgraph_msgs::msg::Clock> topic{"/clock", rt::kClock};
  const auto clock = node_.create_publisher(topic);
  const auto publisher = node_.create_publisher(kPong);
  rt::Node follower{rt::NodeOptions{.name = "follower", .use_sim_time = true}};
  int heard = 0;
  const auto subscription = follower.create_subscription(kPong, [&](const Twist&) { ++heard; });
  subscription.may_wait(1e6);
  const auto show = [&](std::int32_t seconds) {
    rosgraph_msgs::msg::Clock time;
    time.clock().sec(seconds);
    return test::spin_until(
        [&] {
          clock.publish(time);
          return follower.now() == seconds;
        },
        test::kTimeout, follower);
  };
  ASSERT_TRUE(show(100));
  publisher.publish({});
  ASSERT_TRUE(show(1));
  EXPECT_EQ(heard, 0);
  publisher.publish({});
  EXPECT_TRUE(test::spin_until([&] { return heard == 1; }, test::kTimeout, follower));
}

// A batch is 32.
TEST_F(Patience, ANodeSleepsAfterAWholeBatch) {
  const auto publisher = node_.create_publisher(kPong);
  const auto subscription = hear({.depth = 100}, kPatience);
  for (int i = 0; i < 32; ++i) publisher.publish({});
  node_.spin_some(0.0);
  ASSERT_EQ(heard_, 32);
  const std::clock_t begin = std::clock();  // processor time
  const double end = node_.now() + kPatience;
  while (node_.now() < end) node_.spin_some(end - node_.now());
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, kPatience / 2);
}

TEST_F(Patience, EndsWhenTheNodeIsAwake) {
  const auto publisher = node_.create_publisher(kPong);
  int heard_at_once = 0;
  const auto at_once = node_.create_subscription(kPing, [&](const Twist&) {
    EXPECT_EQ(heard_, 1) << "what has waited comes first";
    ++heard_at_once;
  });
  const auto later = hear(rt::kDefault, 1e6);
  const auto waking = node_.create_publisher(kPing);
  node_.spin_some(0.0);
  publisher.publish({});
  waking.publish({});
  EXPECT_TRUE(test::spin_until([&] { return heard_at_once == 1; }, test::kTimeout, node_));
}

}  // namespace
}  // namespace tandem
