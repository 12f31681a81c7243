// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/twist_input.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/domain_view.hpp"

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

// A topic with two types is refused by `ros2 topic echo`.
TEST_F(TwistInputTest, SubscribesToStampedCommandsOnlyWhileTheyArePublished) {
  const auto types = [&] {
    std::set<std::string> all;
    for (const auto& topic : sender_.topics())
      if (topic.name == "/cmd_vel") all.insert(topic.type);
    return all;
  };
  const std::set<std::string> one{"geometry_msgs/msg/Twist"};
  ASSERT_TRUE(await([&] { return types() == one; }));
  for (const double v : {1.0, 2.0}) {
    const auto publisher = sender_.create_publisher(kStamped);
    ASSERT_TRUE(await([&] { return publisher.matched() == 1; }));
    publisher.publish(stamped(v, 0.0));
    ASSERT_TRUE(await([&] { return !got_.empty() && got_.back() == v; }));
    EXPECT_EQ(types().size(), 2U);
    const auto second = sender_.create_publisher(kStamped);
    ASSERT_TRUE(await([&] { return second.matched() == 1; }));
  }
  EXPECT_TRUE(await([&] { return types() == one; }));
}

// The second type is subscribed to in a second participant, under a hidden node name.
TEST_F(TwistInputTest, IsOneNodeInTheViewOfTheDomain) {
  const rt::DomainView view{sender_};
  const auto with_stamp = sender_.create_publisher(kStamped);
  ASSERT_TRUE(await([&] { return with_stamp.matched() == 1; }));
  const auto subscriptions = [&] {
    std::map<std::string, std::string> nodes;  // by type
    for (const auto& endpoint : view.look().endpoints)
      if (endpoint.topic == "/cmd_vel" && !endpoint.writes) nodes[endpoint.type] = endpoint.node;
    return nodes;
  };
  const std::map<std::string, std::string> expected{
      {"geometry_msgs/msg/Twist", "/receiver"}, {"geometry_msgs/msg/TwistStamped", "/receiver"}};
  EXPECT_TRUE(await([&] { return subscriptions() == expected; }));
  std::vector<std::string> nodes;
  for (const auto& participant : view.look().participants)
    nodes.insert(nodes.end(), participant.nodes.begin(), participant.nodes.end());
  std::sort(nodes.begin(), nodes.end());
  EXPECT_EQ(nodes, (std::vector<std::string>{"/receiver", "/sender"}));
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

// The table in bringup/ROS2.md.
TEST(StampsOfCommands, AreThoseOfTheNodesClockOrOfTheSystem) {
  rt::Node source{"clock_source"}, usual{"usual"};
  rt::Node simulated{rt::NodeOptions{.name = "simulated", .use_sim_time = true}};
  const auto clock =
      source.create_publisher(rt::Topic<rosgraph_msgs::msg::Clock>{"/clock", rt::kClock});
  rosgraph_msgs::msg::Clock time;
  time.clock(rt::to_stamp(100'000'000'000));
  ASSERT_TRUE(spin_until(
      [&] {
        clock.publish(time);
        return simulated.now() == 100.0;
      },
      kTimeout, source, simulated));
  const StampCheck by_clock{simulated, "cmd_vel_user", {}}, by_system{usual, "cmd_vel_user", {}};
  const auto at = [](double seconds) {
    return rt::to_stamp(static_cast<std::int64_t>(seconds * 1e9));
  };
  const auto ago = [](double seconds) {
    return rt::to_stamp(rt::system_nanoseconds() - static_cast<std::int64_t>(seconds * 1e9));
  };
  for (const auto* check : {&by_clock, &by_system}) {
    EXPECT_TRUE(check->in_time({}));  // 0
    EXPECT_TRUE(check->in_time(ago(0.1)));
    for (const double off : {2.0, -2.0}) EXPECT_FALSE(check->in_time(ago(off))) << off;
  }
  for (const double off : {0.4, -0.4}) EXPECT_TRUE(by_clock.in_time(at(100.0 + off))) << off;
  for (const double off : {2.0, -2.0}) EXPECT_FALSE(by_clock.in_time(at(100.0 + off))) << off;
  EXPECT_FALSE(by_system.in_time(at(100.0)));
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
