// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/twist_input.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using geometry_msgs::msg::TwistStamped;
using test::spin_until;

constexpr double kTimeout = 10.0;  // [s]
constexpr rt::Topic<Twist> kTopic{"cmd_vel"};
constexpr rt::Topic<TwistStamped> kStamped{"cmd_vel"};

class TwistInputTest : public testing::Test {
 protected:
  // Stamped `age` [s] ago.
  TwistStamped stamped(double v, double age) const {
    TwistStamped msg;
    const auto now = sender_.stamp();
    msg.header().stamp(rt::to_stamp(now.sec() * std::int64_t{1'000'000'000} + now.nanosec() -
                                    static_cast<std::int64_t>(age * 1e9)));
    msg.twist().linear().x(v);
    return msg;
  }
  bool await(const std::function<bool()>& done, double timeout = kTimeout) {
    return spin_until(done, timeout, receiver_, sender_);
  }

  rt::Node sender_{"sender"}, receiver_{"receiver"};
  std::vector<double> got_;
  TwistInput input_{receiver_, kTopic, StampParams{},
                    [this](const Twist2& twist) { got_.push_back(twist.v); }};
};

TEST_F(TwistInputTest, ReceivesBothTypesUnderOneName) {
  const auto plain = sender_.create_publisher(kTopic);
  ASSERT_TRUE(await([&] { return plain.matched() == 1; }));
  const auto with_stamp = sender_.create_publisher(kStamped);
  ASSERT_TRUE(await([&] { return with_stamp.matched() == 1; }));
  Twist msg;
  msg.linear().x(1.0);
  plain.publish(msg);
  ASSERT_TRUE(await([&] { return got_.size() == 1; }));
  with_stamp.publish(stamped(2.0, 0.0));
  ASSERT_TRUE(await([&] { return got_.size() == 2; }));
  EXPECT_EQ(got_, (std::vector<double>{1.0, 2.0}));
}

TEST_F(TwistInputTest, IdentifiesTheSenderOfACommand) {
  const auto plain = sender_.create_publisher(kTopic);
  const auto with_stamp = sender_.create_publisher(kStamped);
  ASSERT_TRUE(await([&] { return plain.matched() == 1 && with_stamp.matched() == 1; }));
  EXPECT_NE(plain.id(), with_stamp.id());
  plain.publish(Twist{});
  ASSERT_TRUE(await([&] { return got_.size() == 1; }));
  EXPECT_EQ(input_.sender(), plain.id());
  with_stamp.publish(stamped(2.0, 0.0));
  ASSERT_TRUE(await([&] { return got_.size() == 2; }));
  EXPECT_EQ(input_.sender(), with_stamp.id());
}

TEST_F(TwistInputTest, DropsOldAndFutureStamps) {
  const auto publisher = sender_.create_publisher(kStamped);
  ASSERT_TRUE(await([&] { return publisher.matched() == 1; }));
  test::CapturedLog log;
  publisher.publish(stamped(1.0, 5.0));
  publisher.publish(stamped(2.0, -5.0));
  const auto fresh = sender_.create_wall_timer(
      0.05, [&] { publisher.publish(stamped(3.0, 0.0)); });  // one of them is on time
  ASSERT_TRUE(await([&] { return !got_.empty(); }));
  EXPECT_EQ(got_.front(), 3.0);
  EXPECT_EQ(log.lines("s ago (max_stamp_age 0.5 s)"), 1);  // the second: held back
}

TEST_F(TwistInputTest, DropsAndLogsNonFiniteCommandsUnlessToldToPassThem) {
  const auto publisher = sender_.create_publisher(kTopic);
  ASSERT_TRUE(await([&] { return publisher.matched() == 1; }));
  test::CapturedLog log;
  Twist none, one;
  none.angular().z(std::numeric_limits<double>::quiet_NaN());
  one.linear().x(1.0);
  publisher.publish(none);
  publisher.publish(one);
  ASSERT_TRUE(await([&] { return !got_.empty(); }));
  EXPECT_EQ(got_, (std::vector<double>{1.0}));
  EXPECT_EQ(log.lines("cmd_vel is not finite: dropped"), 1);
  input_.pass_not_finite();
  publisher.publish(none);
  EXPECT_TRUE(await([&] { return got_.size() == 2; }));
}

TEST_F(TwistInputTest, AcceptsCommandsInTheRobotsFramesButNotInMapOrOdom) {
  const test::CapturedLog log;
  const auto publisher = sender_.create_publisher(kStamped);
  ASSERT_TRUE(await([&] { return publisher.matched() == 1; }));
  double v = 0.0;
  for (const char* frame : {"map", "/odom", "", "base_link", "base_footprint", "joy"}) {
    TwistStamped msg = stamped(v += 1.0, 0.0);
    msg.header().frame_id(frame);
    publisher.publish(msg);
  }
  ASSERT_TRUE(await([&] { return !got_.empty() && got_.back() == 6.0; }));
  EXPECT_GE(got_.front(), 3.0);
  EXPECT_GE(
      log.lines("cmd_vel is given in frame `map`, which does not move with the robot: dropped"), 1);
}

TEST_F(TwistInputTest, AZeroStampCountsAsUnstamped) {
  const auto publisher = sender_.create_publisher(kStamped);
  ASSERT_TRUE(await([&] { return publisher.matched() == 1; }));
  TwistStamped msg;
  msg.twist().linear().x(4.0);
  publisher.publish(msg);
  ASSERT_TRUE(await([&] { return !got_.empty(); }));
  EXPECT_EQ(got_, (std::vector<double>{4.0}));
}

}  // namespace
}  // namespace tandem
