// SPDX-License-Identifier: Apache-2.0
// Tests subscriptions that match every publisher of their topic, and how their samples are counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using std_msgs::msg::Float64;
using test::spin_until;

constexpr double kPatience = 10.0;  // [s]
constexpr rt::Topic<Float64> kStream{"stream", rt::kDefault, rt::Accepts::kEvery};
constexpr rt::Topic<Float64> kKept{"kept", rt::kLatched, rt::Accepts::kEvery};
constexpr rt::QoS kDurable{rt::Reliability::kBestEffort, rt::Durability::kTransientLocal, 1};

Float64 number(double value) {
  Float64 message;
  message.data(value);
  return message;
}

// Two nodes: one subscribes to the publishers of the other.
class AcceptsEvery : public ::testing::Test {
 protected:
  auto hear(const rt::Topic<Float64>& topic) {
    return receiver_.create_subscription(topic,
                                         [this](const auto& msg) { got_.push_back(msg.data()); });
  }
  template <class Predicate>
  [[nodiscard]] bool wait_until(Predicate predicate) {
    return spin_until(predicate, kPatience, receiver_, sender_);
  }
  // Publishes `value` until it is received.
  [[nodiscard]] bool is_heard(const rt::Publisher<Float64>& publisher, double value) {
    return wait_until([&] {
      publisher.publish(number(value));
      return std::find(got_.begin(), got_.end(), value) != got_.end();
    });
  }

  rt::Node receiver_{"receiver"}, sender_{"sender"};
  std::vector<double> got_;
};

TEST_F(AcceptsEvery, KindOfPublisherOfAStream) {
  const auto subscription = hear(kStream);
  double value = 0.0;
  for (const rt::QoS& qos : {rt::kDefault, rt::kBestEffort(1), rt::kLatched, kDurable}) {
    const auto publisher = sender_.create_publisher(kStream, qos);
    EXPECT_TRUE(is_heard(publisher, ++value)) << value;
  }
}

TEST_F(AcceptsEvery, KindOfPublisherOfALatchedTopic) {
  const auto subscription = hear(kKept);
  double value = 0.0;
  for (const rt::QoS& qos : {rt::kDefault, rt::kBestEffort(1), rt::kLatched, kDurable}) {
    const auto publisher = sender_.create_publisher(kKept, qos);
    EXPECT_TRUE(is_heard(publisher, ++value)) << value;
  }
}

TEST_F(AcceptsEvery, PublisherThatWasThereBefore) {
  const auto publisher = sender_.create_publisher(kStream, rt::kBestEffort(1));
  const auto subscription = hear(kStream);
  EXPECT_TRUE(is_heard(publisher, 1.0));
}

TEST_F(AcceptsEvery, LatchedMessagePublishedEarlier) {
  const auto publisher = sender_.create_publisher(kKept);
  publisher.publish(number(1.0));
  const auto subscription = hear(kKept);
  EXPECT_TRUE(wait_until([&] { return got_ == std::vector<double>{1.0}; }));
}

// Three readers all receive what the reliable and the latched publisher send.
TEST_F(AcceptsEvery, MessageOnceAndInOrder) {
  const auto subscription = hear(kKept);
  const rt::QoS deep{rt::Reliability::kReliable, rt::Durability::kTransientLocal, 100};
  const auto weak = sender_.create_publisher(kKept, rt::kBestEffort(100));
  const auto reliable = sender_.create_publisher(kKept, rt::QoS{.depth = 100});
  const auto latched = sender_.create_publisher(kKept, deep);
  ASSERT_TRUE(is_heard(weak, -1.0));
  ASSERT_TRUE(is_heard(reliable, -2.0));
  ASSERT_TRUE(wait_until(
      [&] { return weak.matched() == 1 && reliable.matched() == 2 && latched.matched() == 3; }));
  EXPECT_EQ(subscription.matched(), 3) << "publishers, not pairs of endpoints";
  for (const auto* publisher : {&reliable, &latched}) {
    got_.clear();
    std::vector<double> said;
    for (int i = 0; i < 50; ++i) {
      said.push_back(i);
      publisher->publish(number(i));
      ASSERT_TRUE(wait_until([&] { return got_.size() >= said.size(); }));
    }
    EXPECT_EQ(got_, said);
  }
}

TEST_F(AcceptsEvery, PublisherOnlyWhereTheTopicSaysSo) {
  const auto subscription =
      receiver_.create_subscription(rt::Topic<Float64>{"stream"}, [](const auto&) {});
  const auto weak = sender_.create_publisher(kStream, rt::kBestEffort(1));
  EXPECT_FALSE(spin_until([&] { return weak.matched() > 0; }, 0.5, receiver_, sender_));
}

TEST_F(AcceptsEvery, NothingAfterItIsClosed) {
  auto subscription = hear(kStream);
  const auto weak = sender_.create_publisher(kStream, rt::kBestEffort(1));
  ASSERT_TRUE(is_heard(weak, 1.0));
  subscription = {};
  EXPECT_TRUE(wait_until([&] { return weak.matched() == 0; }));
  const auto another = sender_.create_publisher(kStream, rt::kBestEffort(1));
  EXPECT_FALSE(spin_until([&] { return another.matched() > 0; }, 0.5, receiver_, sender_));
}

// A parameter that requests reliable samples excludes all others; the log says how to change it.
TEST(AcceptsEveryUnless, ParametersForbidIt) {
  test::CapturedLog log;
  rt::NodeOptions options{.name = "strict"};
  options.parameters.values["qos_overrides./stream.subscription.reliability"] = {"reliable",
                                                                                 "test"};
  rt::Node strict{options}, other{"other"};
  const rt::Topic<std_msgs::msg::Float64> stream{"stream", rt::kBestEffort(5), rt::Accepts::kEvery};
  const auto subscription = strict.create_subscription(stream, [](const auto&) {});
  const auto weak = other.create_publisher(kStream, rt::kBestEffort(1));
  EXPECT_TRUE(spin_until(
      [&] {
        return log.lines("set qos_overrides./stream.subscription.reliability: best_effort") == 1;
      },
      kPatience, strict));
  EXPECT_EQ(weak.matched(), 0);
}

TEST_F(AcceptsEvery, SampleWithItsSenderAndNumber) {
  const auto subscription = hear(kStream);
  EXPECT_EQ(subscription.sequence(), 0U);
  const auto first = sender_.create_publisher(kStream), second = sender_.create_publisher(kStream);
  ASSERT_TRUE(wait_until([&] { return first.matched() == 1 && second.matched() == 1; }));
  std::vector<rt::PublisherId> senders;
  for (int i = 1; i <= 3; ++i)
    for (const auto* publisher : {&first, &second}) {
      const std::size_t before = got_.size();
      publisher->publish(number(i));
      ASSERT_TRUE(wait_until([&] { return got_.size() > before; }));
      EXPECT_EQ(subscription.sequence(), static_cast<std::uint64_t>(i));
      senders.push_back(subscription.sender());
    }
  EXPECT_NE(senders[0], senders[1]);
  EXPECT_EQ(senders[0], senders[4]);
  EXPECT_EQ(senders[1], senders[5]);
}

TEST_F(AcceptsEvery, WhetherASenderIsStillThere) {
  const auto subscription = hear(kStream);
  auto publisher = sender_.create_publisher(kStream);
  ASSERT_TRUE(is_heard(publisher, 1.0));
  const rt::PublisherId id = subscription.sender();
  EXPECT_TRUE(receiver_.is_present(id));
  publisher = {};
  EXPECT_TRUE(wait_until([&] { return !receiver_.is_present(id); }));
  EXPECT_FALSE(receiver_.is_present({}));
}

}  // namespace
}  // namespace tandem
