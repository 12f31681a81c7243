// SPDX-License-Identifier: Apache-2.0
// Tests which topics web clients are offered and which messages they receive.
#include "tandem/dashboard/bridge/topic_relay.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "dashboard/bridge/page_client.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

using foxglove::json;

constexpr std::uint32_t kOwnChannel = 1;  // channel of the dashboard itself
constexpr std::size_t kHead = 13;         // opcode, subscription, time of a message's frame

class TopicRelayOverDds : public testing::Test {
 protected:
  // Looks for topics until `topic` is offered; returns its channel.
  json channel_of(const std::string& topic) {
    json channel;
    EXPECT_TRUE(spin_until([&] {
      relay_.look({page_.id()});
      while (page_.has_frame())
        for (const json frame = page_.read_json(); const auto& offered : frame.at("channels"))
          if (offered.at("topic") == topic) channel = offered;
      return !channel.is_null();
    }));
    return channel;
  }
  void subscribe(std::uint32_t subscription, std::uint32_t channel) {
    relay_.subscribe(page_.id(), {{{subscription, channel}}});
    relay_.listen_to_next();
  }
  std::string frame() {
    EXPECT_TRUE(spin_until([&] { return page_.has_frame(); }));
    return page_.read();
  }
  template <class Done>
  bool spin_until(Done done) {
    return test::spin_until(done, test::kTimeout, dashboard_, robot_);
  }

  rt::Node dashboard_{"dashboard"}, robot_{"robot"};
  test::PageClient page_;
  TopicRelay relay_{
      dashboard_, page_.web(), {{kOwnChannel, "/dashboard/seat", "json", "", "", ""}}};
};

TEST_F(TopicRelayOverDds, OffersATopicWithItsSchema) {
  const auto publisher = robot_.create_publisher(topics::cmd_vel);
  const json channel = channel_of("/cmd_vel");
  EXPECT_EQ(channel.at("encoding"), "cdr");
  EXPECT_EQ(channel.at("schemaName"), "geometry_msgs/msg/Twist");
  EXPECT_NE(channel.at("schema").get<std::string>().find("Vector3 linear"), std::string::npos);
}

TEST_F(TopicRelayOverDds, AnnouncesAllChannelsToALaterClient) {
  const auto publisher = robot_.create_publisher(topics::cmd_vel);
  (void)channel_of("/cmd_vel");
  relay_.announce_all(page_.id());
  const json all = page_.read_json();
  EXPECT_EQ(all.at("channels").at(0).at("topic"), "/cmd_vel");
}

TEST_F(TopicRelayOverDds, PassesTheBytesOfASubscribedTopicOn) {
  const auto publisher = robot_.create_publisher(topics::cmd_vel);
  subscribe(7, channel_of("/cmd_vel").at("id"));
  ASSERT_TRUE(spin_until([&] { return publisher.matched() > 0; }));
  geometry_msgs::msg::Twist twist;
  twist.linear().x(0.5);
  publisher.publish(twist);
  const std::string got = frame();
  const auto bytes = rt::encode(twist);
  EXPECT_EQ(got.substr(kHead), std::string(bytes.begin(), bytes.end()));
  EXPECT_EQ(got[1], 7) << "the subscription's number";
}

TEST_F(TopicRelayOverDds, GivesALaterSubscriptionTheLatchedMessage) {
  const auto publisher = robot_.create_publisher(topics::e_stop);
  std_msgs::msg::Bool stop;
  stop.data(true);
  publisher.publish(stop);
  const std::uint32_t channel = channel_of("/e_stop").at("id");
  subscribe(1, channel);
  const std::string first = frame();
  subscribe(2, channel);
  EXPECT_EQ(frame().substr(kHead), first.substr(kHead));
}

TEST_F(TopicRelayOverDds, RefusesMoreThanTheAllowedSubscriptionsOfOneChannel) {
  for (std::uint32_t i = 0; i < TopicRelay::kMaxOfOne; ++i) subscribe(i, kOwnChannel);
  EXPECT_FALSE(page_.has_frame());
  subscribe(9, kOwnChannel);
  EXPECT_EQ(json::parse(frame()).at("message"), "at most 4 subscriptions of one channel");
  subscribe(0, kOwnChannel);
  EXPECT_EQ(json::parse(frame()).at("message"), "subscription 0 is already in use");
  subscribe(9, 77);
  EXPECT_EQ(json::parse(frame()).at("message"), "there is no channel 77");
}

TEST_F(TopicRelayOverDds, ReportsOnItsOwnChannelOnlyToSubscribers) {
  relay_.send_own(page_.id(), kOwnChannel, "early");
  subscribe(3, kOwnChannel);
  relay_.send_own(page_.id(), kOwnChannel, "free");
  EXPECT_EQ(frame().substr(kHead), "free");
  relay_.unsubscribe(page_.id(), {{3}});
  relay_.send_own(page_.id(), kOwnChannel, "late");
  subscribe(4, kOwnChannel);
  relay_.send_own(page_.id(), kOwnChannel, "taken");
  EXPECT_EQ(frame().substr(kHead), "taken");
}

TEST_F(TopicRelayOverDds, WithdrawsTheChannelOfATopicThatHasGone) {
  auto publisher = std::make_optional(robot_.create_publisher(topics::cmd_vel));
  const json channel = channel_of("/cmd_vel");
  publisher.reset();
  json frame;
  ASSERT_TRUE(spin_until([&] {
    relay_.look({page_.id()});
    if (page_.has_frame()) frame = page_.read_json();
    return !frame.is_null() && frame.at("op") == "unadvertise";
  }));
  EXPECT_EQ(frame.at("channelIds"), json::array({channel.at("id")}));
}

}  // namespace
}  // namespace tandem
