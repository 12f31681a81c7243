// SPDX-License-Identifier: Apache-2.0
// Compares the bytes of Tandem's messages with those that a real ROS 2 Jazzy (rclpy) wrote.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "idl/message_fields.hpp"
#include "idl/wire.hpp"
#include "support/paths.hpp"
#include "type_hashes.hpp"

namespace tandem::runtime {
namespace {

std::string vectors_path() {
  const char* shared = std::getenv("TANDEM_SHARED_DIR");
  const std::string file = "ros2/vectors.json";
  return shared ? std::string{shared} + "/" + file : test::shared_path(file);
}

// Entries with bytes, by type name; empty if the file does not exist.
const std::map<std::string, nlohmann::json>& vectors() {
  static const auto all = [] {
    std::map<std::string, nlohmann::json> result;
    std::ifstream file(vectors_path());
    if (!file) return result;
    for (const auto& entry : nlohmann::json::parse(file))
      if (entry.contains("cdr_hex")) result[entry.at("type")] = entry;
    return result;
  }();
  return all;
}

template <class M>
class Vectors : public testing::Test {
 protected:
  void SetUp() override {
    if (vectors().empty()) GTEST_SKIP() << "no " << vectors_path() << " (set TANDEM_SHARED_DIR)";
    ASSERT_TRUE(vectors().contains(MessageType<M>::name)) << MessageType<M>::name;
    entry = vectors().at(MessageType<M>::name);
    bytes = from_hex(entry.at("cdr_hex"));
    fill(entry.at("value"), message);
  }

  nlohmann::json entry;
  Bytes bytes;
  M message;
};

struct Name {
  template <class M>
  static std::string GetName(int) {
    std::string name = MessageType<M>::name;
    for (char& c : name)
      if (c == '/') c = '_';
    return name;
  }
};

TYPED_TEST_SUITE(Vectors, RosMessages, Name);

// Fast CDR 2 takes bytes that end after a field, and leaves the rest of the message as it was.
#if __has_include(<fastcdr/CdrSizeCalculator.hpp>)
constexpr bool kTakesACutEnd = true;
#else
constexpr bool kTakesACutEnd = false;
#endif
constexpr const char* kCodecRefuses = "nodes decode with Codec, which refuses it: hostile_test.cpp";

TYPED_TEST(Vectors, RegistersUnderTheNameThatRos2Uses) {
  EXPECT_EQ(type_name<TypeParam>(), this->entry.at("dds_type").template get<std::string>());
}

TYPED_TEST(Vectors, HasTheHashThatRos2Computes) {
  EXPECT_EQ(type_hash(type_name<TypeParam>()),
            this->entry.at("type_hash").template get<std::string>());
}

TYPED_TEST(Vectors, WritesTheBytesThatRos2Writes) {
  const std::string ours = to_hex(this->message);
  std::string theirs = this->entry.at("cdr_hex");
  ASSERT_LE(ours.size(), theirs.size());
  ASSERT_LT(theirs.size() - ours.size(), 8U);  // rclpy rounds fixed sizes up to 4 bytes
  theirs.resize(ours.size());
  for (size_t i = 0; i < ours.size(); ++i)
    if (ours[i] == '.') theirs[i] = '.';
  EXPECT_EQ(ours, theirs);
}

TYPED_TEST(Vectors, ReadsBackTheValueFromTheBytesOfRos2) {
  TypeParam read;
  ASSERT_TRUE(deserialize(this->bytes, read));
  EXPECT_TRUE(read == this->message);
}

TYPED_TEST(Vectors, RefusesEveryTruncation) {
  if (kTakesACutEnd) GTEST_SKIP() << kCodecRefuses;
  const size_t size = serialize(this->message).size();
  for (size_t n = 0; n < size; ++n) {
    TypeParam read;
    EXPECT_FALSE(deserialize(Bytes(this->bytes.data(), this->bytes.data() + n), read)) << n;
  }
}

TYPED_TEST(Vectors, SurvivesEveryDamagedByte) {
  for (size_t i = 0; i < this->bytes.size(); ++i) {
    for (const int value : {0x00, 0x7f, 0xff}) {
      Bytes damaged = this->bytes;
      damaged[i] = static_cast<uint8_t>(value);
      TypeParam read;
      EXPECT_NO_THROW((void)deserialize(damaged, read)) << "byte " << i << " = " << value;
    }
  }
}

TEST(CheckedType, RefusesABooleanThatIsNeitherTrueNorFalse) {
  std_msgs::msg::Bool read;
  EXPECT_TRUE(deserialize(from_hex("0001000001"), read));
  EXPECT_FALSE(deserialize(from_hex("0001000007"), read));
}

TEST(CheckedType, RefusesASequenceLongerThanItsBytes) {
  sensor_msgs::msg::Joy read;
  EXPECT_FALSE(deserialize(from_hex("00010000"
                                    "0000000000000000"
                                    "0100000000000000"
                                    "ffffffff"),
                           read));
}

TEST(Services, NameTheirRequestAndResponse) {
  static_assert(std::is_same_v<std_srvs::srv::Trigger::Response, std_srvs::srv::Trigger_Response>);
  EXPECT_STREQ(tandem_msgs::srv::SetPolicy::name, "tandem_msgs/srv/SetPolicy");
}

TEST(TypeHash, IsThereForOurOwnTypesAndForNoOther) {
  EXPECT_EQ(type_hash(type_name<tandem_msgs::msg::ObstacleArray>()).size(), 7U + 64U);
  EXPECT_NE(type_hash(type_name<tandem_msgs::msg::ObstacleArray>()),
            type_hash(type_name<tandem_msgs::msg::Obstacle>()));
  EXPECT_EQ(type_hash("their_msgs::msg::dds_::Thing_"), "");
}

TEST(TandemMessages, ReadBackWhatTheyWrote) {
  tandem_msgs::msg::ArbitrationStatus written, read;
  written.header().frame_id("base_link");
  written.policy("shared");
  written.alpha(0.25);
  written.deadman(true);
  written.command().linear().x(0.5);
  written.silent_sources({"planner", "user"});
  written.remedy("let go of the stick for a second");
  written.reason_code().value(tandem_msgs::msg::ReasonCode_Constants::LET_GO_FIRST);
  ASSERT_TRUE(deserialize(serialize(written), read));
  EXPECT_TRUE(read == written);
  EXPECT_EQ(type_name<tandem_msgs::msg::ArbitrationStatus>(),
            "tandem_msgs::msg::dds_::ArbitrationStatus_");
}

// Recordings made before a last field was added contain such messages; see bringup/ROS2.md.
TEST(TandemMessages, AnArbitrationStatusWithoutALastFieldIsRejected) {
  tandem_msgs::msg::ArbitrationStatus status, read;
  status.silent_sources({"user"});
  Bytes bytes = serialize(status);
  bytes.resize(bytes.size() - 6);  // an empty text (its length, and its end), and the reason's code
  EXPECT_FALSE(deserialize(bytes, read));
}

TEST(TandemMessages, AStatusWithoutReasonCodeIsNone) {
  if (kTakesACutEnd) GTEST_SKIP() << kCodecRefuses;
  tandem_msgs::msg::FilterStatus status, read;
  status.reason("clear");
  status.reason_code().value(7);
  Bytes bytes = serialize(status);
  EXPECT_TRUE(deserialize(bytes, read));
  while (bytes.back() == 0) bytes.pop_back();  // Fast CDR 2 pads to four bytes
  ASSERT_EQ(bytes.back(), 7);
  bytes.pop_back();
  EXPECT_FALSE(deserialize(bytes, read));
}

}  // namespace
}  // namespace tandem::runtime
