// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <openssl/sha.h>

#include <cstdio>
#include <optional>
#include <string>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using test::spin_until;
using type_description_interfaces::msg::IndividualTypeDescription;
using type_description_interfaces::msg::TypeDescription;
using type_description_interfaces::srv::GetTypeDescription;

using test::kTimeout;

std::string json(const IndividualTypeDescription& type) {
  std::string text;
  for (const auto& field : type.fields())
    text += (text.empty() ? "" : ", ") + std::string{"{\"name\": \""} + field.name() +
            "\", \"type\": {\"type_id\": " + std::to_string(field.type().type_id()) +
            ", \"capacity\": " + std::to_string(field.type().capacity()) +
            ", \"string_capacity\": " + std::to_string(field.type().string_capacity()) +
            ", \"nested_type_name\": \"" + field.type().nested_type_name().c_str() + "\"}}";
  return std::string{"{\"type_name\": \""} + type.type_name().c_str() + "\", \"fields\": [" + text +
         "]}";
}

// REP-2016, from what the service said.
std::string hash_of(const TypeDescription& type) {
  std::string others;
  for (const auto& other : type.referenced_type_descriptions())
    others += (others.empty() ? "" : ", ") + json(other);
  const std::string text = "{\"type_description\": " + json(type.type_description()) +
                           ", \"referenced_type_descriptions\": [" + others + "]}";
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest);
  std::string result = "RIHS01_";
  for (const unsigned char byte : digest) {
    char hex[3];
    std::snprintf(hex, sizeof hex, "%02x", byte);
    result += hex;
  }
  return result;
}

class TypeDescriptionService : public testing::Test {
 protected:
  GetTypeDescription::Response ask(const std::string& name, const std::string& hash,
                                   bool with_sources = false) {
    GetTypeDescription::Request request;
    request.include_type_sources(with_sources);
    request.type_name(name);
    request.type_hash(hash);
    std::optional<GetTypeDescription::Response> answer;
    client_.call(
        request, [&](const auto& response) { answer = response; }, kTimeout);
    EXPECT_TRUE(spin_until([&] { return answer.has_value(); }, kTimeout, node_, tool_));
    return answer.value_or(GetTypeDescription::Response{});
  }

  rt::Node node_{"known"};
  rt::Node tool_{rt::NodeOptions{.name = "tool", .serves_tools = false}};
  rt::Client<GetTypeDescription> client_ =
      tool_.create_client(rt::ServiceName<GetTypeDescription>{"/known/get_type_description"});
};

// The hashes are those that a real ROS 2 Jazzy computes (tests/idl).
TEST_F(TypeDescriptionService, DescribesWhatTheHashWasMadeOf) {
  for (const auto& [name, hash] : std::initializer_list<std::pair<const char*, const char*>>{
           {"geometry_msgs/msg/Twist",
            "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"},
           {"rcl_interfaces/msg/ParameterDescriptor",  // bounded sequences
            "RIHS01_52175dbfda6c51153101d33d2a9da05743f66f02d5ab2ca9ec4709b46b73d704"},
           {"rcl_interfaces/srv/SetParameters_Request",
            "RIHS01_130d46386b7e84ea9ecf60608a4d83cbe5e5cb7c6cc5b712b7a4e3a6c254e932"}}) {
    const auto answer = ask(name, hash);
    EXPECT_TRUE(answer.successful()) << answer.failure_reason();
    EXPECT_EQ(hash_of(answer.type_description()), hash);
  }
}

TEST_F(TypeDescriptionService, GivesTheSourcesOfATypeOnRequest) {
  EXPECT_TRUE(ask("geometry_msgs/msg/Twist", "").type_sources().empty());
  const auto sources = ask("geometry_msgs/msg/Twist", "", true).type_sources();
  ASSERT_EQ(sources.size(), 2U);
  EXPECT_EQ(sources[0].type_name(), "geometry_msgs/msg/Twist");
  EXPECT_EQ(sources[0].encoding(), "msg");
  EXPECT_EQ(sources[0].raw_file_contents(),
            "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n");
  EXPECT_EQ(sources[1].type_name(), "geometry_msgs/msg/Vector3");
  EXPECT_EQ(sources[1].raw_file_contents(), "float64 x\nfloat64 y\nfloat64 z\n");
}

TEST_F(TypeDescriptionService, GivesNoFileOfARequestButThoseOfItsFields) {
  const auto sources = ask("rcl_interfaces/srv/SetParameters_Request", "", true).type_sources();
  ASSERT_GE(sources.size(), 3U);
  EXPECT_EQ(sources[0].encoding(), "implicit");
  EXPECT_EQ(sources[0].raw_file_contents(), "");
  EXPECT_EQ(sources[1].type_name(), "rcl_interfaces/msg/Parameter");
  EXPECT_EQ(sources[1].raw_file_contents(), "string name\nrcl_interfaces/ParameterValue value\n");
}

TEST_F(TypeDescriptionService, KnowsOurOwnTypesWithoutAHash) {
  const auto answer = ask("tandem_msgs/msg/ObstacleArray", "");
  ASSERT_TRUE(answer.successful());
  EXPECT_STREQ(answer.type_description().type_description().type_name().c_str(),
               "tandem_msgs/msg/ObstacleArray");
  EXPECT_GE(answer.type_description().referenced_type_descriptions().size(), 3U);
}

TEST_F(TypeDescriptionService, SaysWhyItDoesNot) {
  EXPECT_FALSE(ask("their_msgs/msg/Thing", "").successful());
  EXPECT_NE(ask("their_msgs/msg/Thing", "").failure_reason(), "");
  const auto other = ask("geometry_msgs/msg/Twist", "RIHS01_00");
  EXPECT_FALSE(other.successful());
  EXPECT_NE(other.failure_reason().find("RIHS01_9c45"), std::string::npos);
}

}  // namespace
}  // namespace tandem
