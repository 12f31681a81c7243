// SPDX-License-Identifier: Apache-2.0
// Uses messages that tandem_add_interfaces() made from .msg, .srv and .action files.
#include <gtest/gtest.h>

#include <test_msgs/messages.hpp>

#include "ros2_schema.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"
#include "type_hashes.hpp"

namespace tandem {
namespace {

using test_msgs::action::Fibonacci;
using test_msgs::msg::BasicTypes;

constexpr double kTimeout = 10.0;  // [s]
constexpr rt::Topic<BasicTypes> kTopic{"/basic"};
constexpr rt::ServiceName<test_msgs::srv::BasicTypes> kService{"/basic"};
// Of ROS 2 Jazzy and Kilted: share/test_msgs/msg/BasicTypes.json.
constexpr const char* kHash =
    "RIHS01_7c300afd4e796798d49bdd6cdaa0fa87fa0ed2ba3217d977e1faa87070d797ab";

// By type; from the same folder.
const std::pair<const char*, const char*> kKnown[]{
    {"msg::dds_::BasicTypes_", kHash},
    {"msg::dds_::Builtins_",
     "RIHS01_9e61888e7521dda35c21ac6b6cabbcaff8dae88b6d67b25b9078fdb9abf56303"},
    {"srv::dds_::BasicTypes_Request_",
     "RIHS01_1dafcf389e224692783e9c4f6066ba0db3fa75fdbd8f081ffbe7ed03144d73d4"},
    {"srv::dds_::BasicTypes_Response_",
     "RIHS01_8479b3defe554d969e81c6cf8cdaf0b97b4fcd76928b2d644c6813b032673c0d"},
    {"srv::dds_::BasicTypes_Event_",
     "RIHS01_5b9988a4805a06ae22dff12903a774ccda710e9514926b826ffc884e3a9a982e"},
    {"action::dds_::Fibonacci_Goal_",
     "RIHS01_e58ef5a8f4f039ab522a740823547c460b1d5aed8031c8b7825d33d345d90df8"},
    {"action::dds_::Fibonacci_Result_",
     "RIHS01_0774b095467813c6904d475498b5486b7ebd4cda6a4569f97e8de8c862689049"},
    {"action::dds_::Fibonacci_Feedback_",
     "RIHS01_7d1110f2efa019ad5ad8ad2244db98d862f39dc9fae8c976814b0065fa2f32d5"},
    {"action::dds_::Fibonacci_SendGoal_Request_",
     "RIHS01_dfe75c73dc2c090cbc8fd8c45039bfa279d16aa6aadd348f812c6adad26e669e"},
    {"action::dds_::Fibonacci_SendGoal_Response_",
     "RIHS01_1e7e84f7edf1fb020d9e51c7842bceef4cbdbd847f354125f3227cf4f314a683"},
    {"action::dds_::Fibonacci_GetResult_Request_",
     "RIHS01_c65e93c4c4328d7f1abd6ace83dba8e5fa0f32de76b4d2c96b5c655d94803b92"},
    {"action::dds_::Fibonacci_GetResult_Response_",
     "RIHS01_ef88159d47a3d21d9bf4bec690cf668939d9542db28a9cfd77dbcd97eaf1add2"},
    {"action::dds_::Fibonacci_FeedbackMessage_",
     "RIHS01_37487bae8cea358366b97003c1ef1ca7ce7c08df36f9e8cca496624226aee64e"},
    {"action::dds_::NestedMessage_Goal_",
     "RIHS01_88928767537b27c7f9c7c78442e95b78c8a9b8f35877496ec9ca40c3a4a14176"},
    {"action::dds_::NestedMessage_FeedbackMessage_",
     "RIHS01_72ee5828e8083f3c42a56bc5d99fd9e7d5c86389850fc006f254ecdcaecb7d03"}};

TEST(Interfaces, HaveTheTypeHashesOfRos2) {
  for (const auto& [type, hash] : kKnown)
    EXPECT_EQ(rt::type_hash(std::string{"test_msgs::"} + type), hash) << type;
}

// Of rosbag2_interfaces of Jazzy and Kilted, as far as later releases did not change them.
TEST(RecorderServices, HaveTheTypeHashesOfRos2) {
  EXPECT_EQ(rt::type_hash("rosbag2_interfaces::srv::dds_::Record_Response_"),
            "RIHS01_7fcd82e86a46c0f0ee3927b80053c528194e620132a714bfcd207124fc4ae623");
  EXPECT_EQ(rt::type_hash("rosbag2_interfaces::srv::dds_::Stop_Request_"),
            "RIHS01_2ba13fee320757e55d4c44f1de0a13e6bb4511968a2aec7f015436e1e137674e");
}

TEST(Interfaces, HaveADefinitionWithConstants) {
  const std::string definition = rt::ros2msg("test_msgs/msg/BasicTypes").value_or("");
  EXPECT_TRUE(definition.starts_with(
      "uint8 MOST=255\nstring URL=\"https://design.ros2.org; a text\"\nbool bool_value\n"))
      << definition;
}

TEST(Interfaces, HaveTheConstantsOfTheirFile) {
  EXPECT_EQ(test_msgs::msg::BasicTypes_Constants::MOST, 255);
  EXPECT_EQ(test_msgs::msg::BasicTypes_Constants::URL, "https://design.ros2.org; a text");
}

TEST(Interfaces, HaveTheDefaultValuesOfTheirFile) {
  EXPECT_EQ(test_msgs::msg::BasicTypes{}.char_value(), 100);
  const std::string definition = rt::ros2msg("test_msgs/msg/BasicTypes").value_or("");
  EXPECT_NE(definition.find("uint8 char_value 100\n"), std::string::npos) << definition;
}

TEST(Interfaces, OfAnActionNameItsParts) {
  static_assert(std::is_same_v<Fibonacci::Goal, test_msgs::action::Fibonacci_Goal>);
  static_assert(
      std::is_same_v<Fibonacci::SendGoal::Request, test_msgs::action::Fibonacci_SendGoal_Request>);
  EXPECT_STREQ(Fibonacci::name, "test_msgs/action/Fibonacci");
  EXPECT_STREQ(Fibonacci::GetResult::name, "test_msgs/action/Fibonacci_GetResult");
}

TEST(Interfaces, ArePublishedAndReceivedAndAnnounceTheirHash) {
  rt::Node node{"basic"};
  BasicTypes received;
  const auto in = node.create_subscription(kTopic, [&](const BasicTypes& m) { received = m; });
  const auto out = node.create_publisher(kTopic);
  ASSERT_TRUE(
      test::spin_until([&] { return in.matched() == 1 && out.matched() == 1; }, kTimeout, node));
  BasicTypes sent;
  sent.int32_value(3);
  out.publish(sent);
  EXPECT_TRUE(test::spin_until([&] { return received.int32_value() == 3; }, kTimeout, node));
  const auto topics = node.topics();
  const auto topic = std::find_if(topics.begin(), topics.end(),
                                  [](const auto& each) { return each.name == "/basic"; });
  ASSERT_NE(topic, topics.end());
  EXPECT_EQ(topic->type, "test_msgs/msg/BasicTypes");
  EXPECT_EQ(topic->type_hash, kHash);
}

TEST(Interfaces, ServeAService) {
  rt::Node node{"basic"};
  const auto service = node.create_service(kService, [](const auto& request, auto& response) {
    response.bool_value(request.int32_value() == 7);
  });
  const auto client = node.create_client(kService);
  test_msgs::srv::BasicTypes::Request request;
  request.int32_value(7);
  bool success = false;
  client.call(
      request, [&](const auto& response) { success = response.bool_value(); }, kTimeout);
  EXPECT_TRUE(test::spin_until([&] { return success; }, kTimeout, node));
}

}  // namespace
}  // namespace tandem
