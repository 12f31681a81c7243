// SPDX-License-Identifier: Apache-2.0
// Tests what of a web client's messages is published on the domain.
#include "tandem/dashboard/bridge/publish_relay.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

using Outcome = PublishRelay::Outcome;

constexpr double kTimeout = 10.0;  // [s]
constexpr ClientId kClient = 1;
constexpr std::uint32_t kJoy = 1, kStop = 2, kGoal = 3;
constexpr double kMaxAge = 0.5;  // [s]

foxglove::Advertise one(std::uint32_t channel, const std::string& topic, const std::string& type,
                        const std::string& encoding = "cdr") {
  return {{{channel, topic, encoding, type}}};
}

std::vector<std::uint8_t> pressed(bool is_pressed) {
  std_msgs::msg::Bool msg;
  msg.data(is_pressed);
  return rt::encode(msg);
}

class PublishRelayOverDds : public testing::Test {
 protected:
  PublishRelayOverDds() {
    EXPECT_EQ(relay_.advertise(kClient, one(kJoy, "/joy", "sensor_msgs/msg/Joy")), "");
    EXPECT_EQ(relay_.advertise(kClient, one(kStop, "/e_stop", "std_msgs/msg/Bool")), "");
    EXPECT_EQ(relay_.advertise(kClient, one(kGoal, "goal_pose", "geometry_msgs/PoseStamped")), "")
        << "relative, and without /msg/, as Lichtblick writes it";
  }
  Outcome publish(std::uint32_t channel, const std::vector<std::uint8_t>& bytes,
                  bool may_drive = true) {
    return relay_.publish(kClient, {channel, bytes}, [may_drive] { return may_drive; });
  }
  // The stick with a stamp of `age` [s] ago.
  [[nodiscard]] std::vector<std::uint8_t> stick(double age) const {
    sensor_msgs::msg::Joy joy;
    joy.header().stamp(
        rt::to_stamp(rt::system_nanoseconds() - static_cast<std::int64_t>(1e9 * age)));
    joy.axes({0.0F, 0.7F});
    return rt::encode(joy);
  }
  bool wait_until(const std::function<bool()>& done) {
    return test::spin_until(done, kTimeout, dashboard_, robot_);
  }

  rt::Node dashboard_{"dashboard"}, robot_{"robot"};
  PublishRelay relay_{dashboard_, kMaxAge};
};

TEST_F(PublishRelayOverDds, RefusesTopicsThatCouldBypassTheFilterAndWrongTypes) {
  EXPECT_EQ(relay_.advertise(kClient, one(9, "/cmd_vel", "geometry_msgs/msg/Twist")),
            "web clients may not publish /cmd_vel");
  EXPECT_EQ(relay_.advertise(kClient, one(9, "/joy", "std_msgs/msg/Bool")),
            "/joy takes sensor_msgs/msg/Joy in cdr");
  EXPECT_EQ(relay_.advertise(kClient, one(9, "/joy", "sensor_msgs/msg/Joy", "json")),
            "/joy takes sensor_msgs/msg/Joy in cdr");
  EXPECT_EQ(publish(9, stick(0.0)), Outcome::kNoChannel);
}

TEST_F(PublishRelayOverDds, LimitsTheChannelsOfAClient) {
  for (std::uint32_t i = 0; i < PublishRelay::kMaxChannels - 3; ++i)
    ASSERT_EQ(relay_.advertise(kClient, one(100 + i, "/joy", "sensor_msgs/msg/Joy")), "");
  EXPECT_NE(relay_.advertise(kClient, one(99, "/joy", "sensor_msgs/msg/Joy")), "");
  relay_.forget(kClient);
  EXPECT_EQ(relay_.advertise(kClient, one(99, "/joy", "sensor_msgs/msg/Joy")), "");
}

TEST_F(PublishRelayOverDds, AClosedChannelPublishesNothing) {
  relay_.unadvertise(kClient, {{kJoy}});
  EXPECT_EQ(publish(kJoy, stick(0.0)), Outcome::kNoChannel);
}

TEST_F(PublishRelayOverDds, OnlyTheDriverMovesTheRobotButEverybodyMayStopIt) {
  EXPECT_EQ(publish(kJoy, stick(0.0), false), Outcome::kOtherDrives);
  EXPECT_EQ(publish(kGoal, rt::encode(geometry_msgs::msg::PoseStamped{}), false),
            Outcome::kOtherDrives);
  EXPECT_EQ(publish(kStop, pressed(true), false), Outcome::kPublished);
}

TEST_F(PublishRelayOverDds, RefusesBytesThatAreNotOfTheType) {
  for (const std::uint32_t channel : {kJoy, kStop, kGoal})
    EXPECT_EQ(publish(channel, {0, 1, 0}), Outcome::kMalformed) << channel;
}

TEST_F(PublishRelayOverDds, DropsAStickThatIsTooOldAndStampsTheOthersAnew) {
  EXPECT_EQ(publish(kJoy, stick(2.0 * kMaxAge)), Outcome::kOld);
  std::vector<sensor_msgs::msg::Joy> got;
  const auto subscription =
      robot_.create_subscription(topics::joy, [&](const auto& msg) { got.push_back(msg); });
  ASSERT_TRUE(wait_until([&] {
    EXPECT_EQ(publish(kJoy, stick(0.0)), Outcome::kPublished);
    return !got.empty();
  }));
  EXPECT_EQ(got[0].header().frame_id(), "dashboard");
  EXPECT_EQ(got[0].axes(), (std::vector<float>{0.0F, 0.7F}));
}

TEST_F(PublishRelayOverDds, AStickWithoutAStampIsOfAnyAge) {
  EXPECT_EQ(publish(kJoy, rt::encode(sensor_msgs::msg::Joy{})), Outcome::kPublished);
}

// Another program's emergency stop must not be released by a page that merely opens.
TEST_F(PublishRelayOverDds, ReleasesOnlyAStopThatWasPressedHere) {
  std::vector<bool> got;
  const auto subscription = robot_.create_subscription(
      topics::e_stop, [&](const auto& msg) { got.push_back(msg.data()); });
  const auto send = [&](bool is_pressed) {
    EXPECT_EQ(publish(kStop, pressed(is_pressed)), Outcome::kPublished);
  };
  send(true);
  ASSERT_TRUE(wait_until([&] { return got.size() == 1; }));  // latched
  send(false);
  ASSERT_TRUE(wait_until([&] { return got.size() == 2; }));
  send(false);  // has no effect
  send(true);
  ASSERT_TRUE(wait_until([&] { return got.size() >= 3; }));
  EXPECT_EQ(got, (std::vector<bool>{true, false, true}));
}

TEST_F(PublishRelayOverDds, OnlyTheStopIsUrgent) {
  EXPECT_EQ(relay_.urgent_prefixes(kClient),
            std::vector<std::string>{foxglove::message_prefix(kStop)});
  EXPECT_TRUE(relay_.urgent_prefixes(kClient + 1).empty());
}

}  // namespace
}  // namespace tandem
