// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/clock_source.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using rosgraph_msgs::msg::Clock;
using test::kTimeout;
using test::spin_until;

Clock clock_at(double seconds) {
  Clock message;
  message.clock(rt::to_stamp(static_cast<std::int64_t>(seconds * 1e9)));
  return message;
}

class ClockSourceTest : public testing::Test {
 protected:
  ClockSourceTest() {
    EXPECT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  }

  // Publishes a time and waits for it.
  void set_clock(double seconds) {
    const auto time = static_cast<std::int64_t>(seconds * 1e9);
    clock_.publish(clock_at(seconds));
    ASSERT_TRUE(spin_until([&] { return first_.read().time == time; }, kTimeout, node_));
  }

  rt::Node node_{"clock_publisher"};
  rt::Publisher<Clock> clock_{node_.create_publisher(rt::Topic<Clock>{"/clock", rt::kClock})};
  std::shared_ptr<rt::Participant> participant_ = rt::Participant::shared();
  rt::Endpoint endpoint_{rt::dds_topic_name("/clock"), rt::Codec{rt::type_ref<Clock>()}.dds_name(),
                         rt::kClock};
  rt::ClockFollower first_{participant_->clock(endpoint_), [] {}};
  int woken_ = 0;
  rt::ClockFollower follower_{participant_->clock(endpoint_), [this] { ++woken_; }};
};

TEST_F(ClockSourceTest, WakesAFollowerWhenItsTimeHasCome) {
  EXPECT_FALSE(follower_.is_due(1.0));
  set_clock(0.5);
  EXPECT_EQ(woken_, 0);
  set_clock(1.0);
  EXPECT_EQ(woken_, 1);
  set_clock(1.5);
  EXPECT_EQ(woken_, 1) << "it has not waited again";
  EXPECT_EQ(follower_.read().time, 1'500'000'000);
}

TEST_F(ClockSourceTest, WakesNobodyForATimeThatHasPassed) {
  set_clock(1.5);
  EXPECT_TRUE(follower_.is_due(1.5));
  set_clock(2.0);
  EXPECT_EQ(woken_, 0);
}

TEST_F(ClockSourceTest, ReportsAJumpBackToEachFollowerOnce) {
  set_clock(12.5);
  EXPECT_FALSE(follower_.read().jumped_back);
  EXPECT_FALSE(follower_.is_due(20.0));
  set_clock(3.0);
  EXPECT_EQ(woken_, 1);
  EXPECT_TRUE(follower_.is_due(20.0)) << "the jump is not read yet";
  EXPECT_TRUE(follower_.read().jumped_back);
  EXPECT_FALSE(follower_.read().jumped_back);
}

TEST_F(ClockSourceTest, TellsALateFollowerTheTimeButNotEarlierJumps) {
  set_clock(12.5);
  set_clock(3.0);
  rt::ClockFollower late{participant_->clock(endpoint_), [] {}};
  const auto reading = late.read();
  EXPECT_EQ(reading.time, 3'000'000'000);
  EXPECT_GT(reading.arrival, 0.0);
  EXPECT_FALSE(reading.jumped_back);
}

TEST_F(ClockSourceTest, IsOneForATopicAndAQos) {
  rt::Endpoint other_topic = endpoint_, other_qos = endpoint_;
  other_topic.topic = rt::dds_topic_name("/other_clock");
  other_qos.qos.depth = 5;
  const auto source = participant_->clock(endpoint_);
  EXPECT_EQ(participant_->clock(endpoint_), source);
  EXPECT_NE(participant_->clock(other_topic), source);
  EXPECT_NE(participant_->clock(other_qos), source);
}

// A publisher of this process and what comes through DDS, each on its thread.
TEST_F(ClockSourceTest, TakesTwoClocksAtOnce) {
  constexpr int kMany = 3000;
  rt::Writer writer{*participant_, endpoint_};
  ASSERT_TRUE(spin_until([&] { return writer.matched() == 1; }, kTimeout, node_));
  std::thread through_dds{[&] {
    for (int i = 0; i < kMany; ++i) (void)writer.write(rt::encode(clock_at(1.0)));
  }};
  for (int i = 0; i < kMany; ++i) clock_.publish(clock_at(2.0));
  through_dds.join();
  EXPECT_GT(follower_.read().time, 0);
}

TEST_F(ClockSourceTest, TellsOneFollowerWhatWasDropped) {
  EXPECT_FALSE(follower_.is_due(1.0));
  rt::Writer writer{*participant_, endpoint_};
  ASSERT_TRUE(spin_until([&] { return writer.matched() == 1; }, kTimeout, node_));
  ASSERT_TRUE(writer.write({0, 1, 0, 0, 7}));
  ASSERT_TRUE(spin_until([&] { return woken_ == 1; }, kTimeout, node_));
  EXPECT_EQ(follower_.read().refused, "5 bytes that are not a valid rosgraph_msgs/msg/Clock");
  EXPECT_EQ(first_.read().refused, "");
}

}  // namespace
}  // namespace tandem
