// SPDX-License-Identifier: Apache-2.0
// Messages between nodes of one process, which go by pointer instead of through DDS.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using test::CapturedLog;
using test::ChildProcess;
using test::kTimeout;
using test::spin_until;

constexpr rt::Topic<Twist> kPing{"ping"};

Twist twist(double v) {
  Twist message;
  message.linear().x(v);
  return message;
}

class Direct : public ::testing::Test {
 protected:
  auto hear(const rt::QoS& qos = rt::kDefault) {
    return node_.create_subscription(kPing, qos,
                                     [this](const Twist& m) { got_.push_back(m.linear().x()); });
  }
  // Runs the callbacks of messages that have been published.
  void deliver() { node_.spin_some(0.0); }

  rt::Node node_{"direct"};
  std::vector<double> got_;
};

TEST_F(Direct, ArrivesAtOnceWithoutWaitingForDiscovery) {
  const auto publisher = node_.create_publisher(kPing);
  const auto subscription = hear();
  publisher.publish(twist(1.0));
  deliver();
  EXPECT_EQ(got_, std::vector<double>{1.0});
  EXPECT_EQ(subscription.sender(), publisher.id());
  EXPECT_EQ(subscription.sequence(), 1U);
}

TEST_F(Direct, ArrivesAtAPublisherThatIsLater) {
  const auto subscription = hear();
  const auto publisher = node_.create_publisher(kPing);
  publisher.publish(twist(1.0));
  deliver();
  EXPECT_EQ(got_, std::vector<double>{1.0});
}

// DDS brings the message once more to this process, because it carries it to the other one.
TEST_F(Direct, ArrivesOnceBesideASubscriptionOfAnotherProcess) {
  ChildProcess peer{"peer", {"echo"}};
  const auto publisher = node_.create_publisher(kPing);
  const auto subscription = hear();
  for (int i = 0; i < 100; ++i) (void)node_.create_publisher(kPing);  // others come and go
  double answered = -1.0;
  const auto pong =
      node_.create_subscription(rt::Topic<Twist>{"pong", rt::kLatched},
                                [&](const Twist& message) { answered = message.linear().x(); });
  ASSERT_TRUE(
      spin_until([&] { return publisher.matched() == 2 && pong.matched() == 1; }, kTimeout, node_));
  std::vector<double> sent;
  for (int i = 0; i < 50; ++i) {
    sent.push_back(i);
    publisher.publish(twist(i));
    ASSERT_TRUE(spin_until([&] { return answered == i; }, kTimeout, node_)) << i;
  }
  EXPECT_EQ(got_, sent);
}

TEST_F(Direct, KeepsTheLastMessages) {
  const auto publisher = node_.create_publisher(kPing);
  const auto subscription = hear(rt::kBestEffort(2));
  for (int i = 0; i < 5; ++i) publisher.publish(twist(i));
  deliver();
  EXPECT_EQ(got_, (std::vector<double>{3.0, 4.0}));
  EXPECT_EQ(subscription.sequence(), 5U);
}

TEST_F(Direct, DropsWhatIsOlderThanItsLifespan) {
  const CapturedLog log;
  rt::QoS short_lived = rt::kDefault;
  short_lived.lifespan = 0.02;
  const auto publisher = node_.create_publisher(kPing);
  const auto subscription = hear(short_lived);
  publisher.publish(twist(1.0));
  rt::Node other{"other"};
  (void)spin_until([] { return false; }, 0.05, other);
  publisher.publish(twist(2.0));
  deliver();
  EXPECT_EQ(got_, std::vector<double>{2.0});
  EXPECT_EQ(log.lines("/ping: dropped a message that arrived more than 0.02 s late"), 1);
}

TEST_F(Direct, IsDroppedIfItsBytesAreNoMessage) {
  const CapturedLog log;
  const auto publisher =
      node_.create_generic_publisher("ping", "geometry_msgs/msg/Twist", rt::kDefault);
  const auto subscription = hear();
  publisher.publish({0, 1, 0, 0, 7});
  publisher.publish(rt::encode(twist(2.0)));
  deliver();
  EXPECT_EQ(got_, std::vector<double>{2.0});
  EXPECT_EQ(subscription.malformed(), 1);
  EXPECT_EQ(log.lines("/ping: dropped 5 bytes that are not a valid geometry_msgs/msg/Twist"), 1);
}

TEST_F(Direct, IsSerializedForASubscriptionByName) {
  const auto publisher = node_.create_publisher(kPing);
  std::vector<std::uint8_t> bytes;
  const auto subscription = node_.create_generic_subscription(
      "ping", "geometry_msgs/msg/Twist", rt::kDefault, [&](const auto& got) { bytes = got; });
  publisher.publish(twist(3.0));
  deliver();
  EXPECT_EQ(bytes, rt::encode(twist(3.0)));
}

TEST_F(Direct, DoesNotReachASubscriptionThatRequestsMore) {
  const auto publisher = node_.create_publisher(kPing, rt::kBestEffort(5));
  const auto reliable = hear();
  publisher.publish(twist(1.0));
  deliver();
  EXPECT_TRUE(got_.empty());
}

TEST_F(Direct, DoesNotReachAnotherTypeOfTheTopic) {
  const auto publisher = node_.create_publisher(rt::Topic<std_msgs::msg::Float64>{"ping"});
  const auto subscription = hear();
  publisher.publish({});
  deliver();
  EXPECT_TRUE(got_.empty());
}

// Publishers of other threads, while subscriptions come and go; meant for ThreadSanitizer.
TEST_F(Direct, MayBePublishedByManyThreads) {
  constexpr int kThreads = 4, kEach = 500;
  const auto subscription = hear(rt::QoS{.depth = kThreads * kEach});
  std::vector<rt::Publisher<Twist>> publishers;
  for (int i = 0; i < kThreads; ++i) publishers.push_back(node_.create_publisher(kPing));
  std::atomic<int> running = kThreads;
  std::vector<std::thread> threads;
  for (auto& publisher : publishers)
    threads.emplace_back([&] {
      for (int i = 0; i < kEach; ++i) publisher.publish(twist(i));
      --running;
    });
  int passing = 0;
  while (running > 0) {
    const auto other = node_.create_subscription(kPing, [&](const Twist&) { ++passing; });
    deliver();
  }
  for (auto& thread : threads) thread.join();
  EXPECT_TRUE(spin_until([&] { return got_.size() == kThreads * kEach; }, kTimeout, node_))
      << got_.size();
}

}  // namespace
}  // namespace tandem
