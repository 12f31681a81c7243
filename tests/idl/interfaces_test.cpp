// SPDX-License-Identifier: Apache-2.0
// Uses messages that tandem_add_interfaces() made from .msg and .srv files.
#include <gtest/gtest.h>

#include <lifecycle_msgs/messages.hpp>

#include "ros2_schema.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"
#include "type_hashes.hpp"

namespace tandem {
namespace {

using lifecycle_msgs::msg::State;
using lifecycle_msgs::srv::ChangeState;

constexpr double kTimeout = 10.0;  // [s]
constexpr rt::Topic<State> kState{"/state"};
constexpr rt::ServiceName<ChangeState> kChange{"/change"};
// Of ROS 2 Kilted: share/lifecycle_msgs/msg/State.json.
constexpr const char* kStateHash =
    "RIHS01_dd2d02b82f3ebc858e53c431b1e6e91f3ffc71436fc81d0715214ac6ee2107a0";

TEST(Interfaces, HaveTheTypeHashesOfRos2) {
  const std::pair<const char*, const char*> known[]{
      {"msg::dds_::State_", kStateHash},
      {"msg::dds_::Transition_",
       "RIHS01_c65d7b31ea134cba4f54fc867b817979be799f7452035cd35fac9b7421fb3424"},
      {"msg::dds_::TransitionDescription_",
       "RIHS01_c5f1cd4bb1ad2ba0e3329d4ac7015c52a674a72c1faf7974c37a33f4f6048b28"},
      {"srv::dds_::ChangeState_Request_",
       "RIHS01_d74c6f524e14cade7b67e7297190360ed749264af300524fc1456f27cc2a553a"},
      {"srv::dds_::ChangeState_Response_",
       "RIHS01_e1ddfed0271fefe63767aa71561926e4d9eac0f1ddf9e71a8873eb46b36deac2"}};
  for (const auto& [type, hash] : known)
    EXPECT_EQ(rt::type_hash(std::string{"lifecycle_msgs::"} + type), hash) << type;
}

// Of rosbag2_interfaces of Jazzy and Kilted, as far as later releases did not change them.
TEST(RecorderServices, HaveTheTypeHashesOfRos2) {
  EXPECT_EQ(rt::type_hash("rosbag2_interfaces::srv::dds_::Record_Response_"),
            "RIHS01_7fcd82e86a46c0f0ee3927b80053c528194e620132a714bfcd207124fc4ae623");
  EXPECT_EQ(rt::type_hash("rosbag2_interfaces::srv::dds_::Stop_Request_"),
            "RIHS01_2ba13fee320757e55d4c44f1de0a13e6bb4511968a2aec7f015436e1e137674e");
}

TEST(Interfaces, HaveADefinitionWithConstants) {
  EXPECT_EQ(rt::ros2msg("lifecycle_msgs/msg/State"),
            "uint8 PRIMARY_STATE_UNKNOWN=0\nstring URL=\"https://design.ros2.org; a text\"\n"
            "uint8 id\nstring label\n");
}

TEST(Interfaces, HaveTheConstantsOfTheirFile) {
  EXPECT_EQ(lifecycle_msgs::msg::State_Constants::PRIMARY_STATE_UNKNOWN, 0);
  EXPECT_EQ(lifecycle_msgs::msg::State_Constants::URL, "https://design.ros2.org; a text");
}

TEST(Interfaces, ArePublishedAndReceivedAndAnnounceTheirHash) {
  rt::Node node{"lifecycle"};
  State received;
  const auto in = node.create_subscription(kState, [&](const State& m) { received = m; });
  const auto out = node.create_publisher(kState);
  ASSERT_TRUE(
      test::spin_until([&] { return in.matched() == 1 && out.matched() == 1; }, kTimeout, node));
  State sent;
  sent.id(3);
  sent.label("active");
  out.publish(sent);
  EXPECT_TRUE(test::spin_until([&] { return received.label() == "active"; }, kTimeout, node));
  const auto topics = node.topics();
  const auto topic = std::find_if(topics.begin(), topics.end(),
                                  [](const auto& each) { return each.name == "/state"; });
  ASSERT_NE(topic, topics.end());
  EXPECT_EQ(topic->type, "lifecycle_msgs/msg/State");
  EXPECT_EQ(topic->type_hash, kStateHash);
}

TEST(Interfaces, ServeAService) {
  rt::Node node{"lifecycle"};
  const auto service = node.create_service(kChange, [](const auto& request, auto& response) {
    response.success(request.transition().id() == 7);
  });
  const auto client = node.create_client(kChange);
  ChangeState::Request request;
  request.transition().id(7);
  bool success = false;
  client.call(
      request, [&](const auto& response) { success = response.success(); }, kTimeout);
  EXPECT_TRUE(test::spin_until([&] { return success; }, kTimeout, node));
}

}  // namespace
}  // namespace tandem
