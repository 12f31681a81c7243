// SPDX-License-Identifier: Apache-2.0
// Sends bytes that are not a valid message: they must never reach a callback or end the process.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using rt::Bytes;

struct GainParams {
  double gain = 1.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("gain", gain, Range{0.0, 2.0}, "[1]");
  }
};

using test::spin_until;

using test::kTimeout;

template <class M>
Bytes encoded(const M& message) {
  Bytes bytes;
  EXPECT_TRUE(rt::Codec{rt::type_ref<M>()}.encode(&message, bytes));
  return bytes;
}

template <class M>
bool decodes(const Bytes& bytes) {
  M message;
  return rt::Codec{rt::type_ref<M>()}.decode(bytes, &message);
}

Bytes with_length(Bytes bytes, std::size_t at, std::uint32_t length) {
  std::memcpy(bytes.data() + at, &length, sizeof length);
  return bytes;
}

std_msgs::msg::String text() {
  std_msgs::msg::String message;
  message.data("hello");
  return message;
}

visualization_msgs::msg::MarkerArray markers() {
  visualization_msgs::msg::MarkerArray message;
  message.markers().resize(3);
  message.markers()[1].ns("poles");
  message.markers()[1].points().resize(4);
  return message;
}

TEST(Codec, RefusesEveryTruncation) {
  const Bytes good = encoded(markers());
  ASSERT_TRUE(decodes<visualization_msgs::msg::MarkerArray>(good));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(decodes<visualization_msgs::msg::MarkerArray>(
        {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}))
        << size;
}

TEST(Codec, RefusesMoreBytesThanTheMessageHas) {
  Bytes bytes = encoded(text());
  bytes.resize(bytes.size() + 3);
  EXPECT_TRUE(decodes<std_msgs::msg::String>(bytes));  // padding
  bytes.resize(bytes.size() + 1);
  EXPECT_FALSE(decodes<std_msgs::msg::String>(bytes));
}

TEST(Codec, RefusesLengthsBeyondTheEnd) {
  for (const std::uint32_t length : {0xFFFFFFFFU, 0x7FFFFFFFU, 0x80000000U, 1000U}) {
    EXPECT_FALSE(decodes<std_msgs::msg::String>(with_length(encoded(text()), 4, length)));
    EXPECT_FALSE(
        decodes<visualization_msgs::msg::MarkerArray>(with_length(encoded(markers()), 4, length)));
  }
}

// Every node accepts these from any sender.
TEST(Codec, AcceptsLessFromParameterRequests) {
  rcl_interfaces::srv::GetParameters::Request request;
  request.names(std::vector<std::string>(1000, "a_name_of_usual_length"));
  EXPECT_TRUE(decodes<rcl_interfaces::srv::GetParameters::Request>(encoded(request)));
  Bytes bytes = with_length(Bytes(200'000, 0), 4, 150'000);
  bytes[1] = 1;
  EXPECT_FALSE(decodes<rcl_interfaces::srv::SetParameters::Request>(bytes));
}

TEST(Codec, RefusesAnUnknownEncapsulation) {
  for (const auto kind : std::to_array<std::uint8_t>({2, 3, 6, 7, 255})) {
    Bytes bytes = encoded(text());
    bytes[1] = kind;
    EXPECT_FALSE(decodes<std_msgs::msg::String>(bytes)) << int{kind};
  }
}

TEST(Codec, RefusesAnInvalidBoolean) {
  Bytes bytes = encoded(std_msgs::msg::Bool{});
  bytes[4] = 7;
  EXPECT_FALSE(decodes<std_msgs::msg::Bool>(bytes));
}

TEST(Codec, RefusesAMessageTooLargeToBelieve) {
  std_msgs::msg::String message;
  message.data(std::string(2U << 20, 'x'));
  Bytes bytes;
  EXPECT_FALSE((rt::Codec{rt::type_ref<std_msgs::msg::String>()}.encode(&message, bytes)));
  EXPECT_FALSE(decodes<std_msgs::msg::String>(bytes));
}

// Flips bytes of valid messages: decoding must not throw or read out of bounds.
template <class M>
void fuzz(const M& message) {
  const rt::Codec codec{rt::type_ref<M>()};
  const Bytes good = encoded(message);
  std::mt19937 random{7};
  M out;
  for (int round = 0; round < 20'000; ++round) {
    Bytes bad = good;
    for (auto flips = 1 + random() % 4; flips > 0; --flips)
      bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) bad.resize(random() % bad.size());
    (void)codec.decode(bad, &out);
  }
}

TEST(Codec, SurvivesFlippedBytes) {
  fuzz(markers());
  fuzz(nav_msgs::msg::Odometry{});
  diagnostic_msgs::msg::DiagnosticArray diagnostics;
  diagnostics.status().resize(2);
  diagnostics.status()[0].values().resize(3);
  fuzz(diagnostics);
  octomap_msgs::msg::Octomap map;
  map.data().assign(100, 1);
  fuzz(map);
  tandem_msgs::msg::ObstacleArray obstacles;
  fuzz(obstacles);
}

class HostileSender : public testing::Test {
 protected:
  // Publishes `bad`, then a valid message, through DDS; returns how many messages the callback
  // received.
  template <class M>
  void expect_only_the_good_one(const std::vector<Bytes>& bad, const M& good) {
    int got = 0;
    const auto subscription =
        node_.create_subscription(rt::Topic<M>{"attacked"}, [&](const M& message) {
          EXPECT_EQ(message, good);
          ++got;
        });
    const auto participant = rt::Participant::shared();
    rt::Writer writer{*participant,
                      {"rt/attacked", rt::Codec{rt::type_ref<M>()}.dds_name(), rt::kDefault}};
    ASSERT_TRUE(spin_until([&] { return writer.matched() == 1; }, kTimeout, node_));
    for (const Bytes& bytes : bad) {
      const auto dropped = subscription.malformed();
      ASSERT_TRUE(writer.write(bytes));
      EXPECT_TRUE(
          spin_until([&] { return subscription.malformed() == dropped + 1; }, kTimeout, node_));
    }
    ASSERT_TRUE(writer.write(encoded(good)));
    ASSERT_TRUE(spin_until([&] { return got == 1; }, kTimeout, node_));
  }

  rt::Node node_{"victim"};
};

TEST_F(HostileSender, TextIsReceivedOnlyWhenWellFormed) {
  const Bytes good = encoded(text());
  expect_only_the_good_one<std_msgs::msg::String>({{},
                                                   {0},
                                                   {0, 1, 0, 0},
                                                   {good.begin(), good.end() - 3},
                                                   with_length(good, 4, 0xFFFFFFFFU),
                                                   Bytes(100'000, 0xFF)},
                                                  text());
}

TEST_F(HostileSender, SequencesAreReceivedOnlyWhenWellFormed) {
  const Bytes good = encoded(markers());
  expect_only_the_good_one<visualization_msgs::msg::MarkerArray>(
      {with_length(good, 4, 0xFFFFFFFFU), with_length(good, 4, 4), {good.begin(), good.end() - 20}},
      markers());
}

TEST_F(HostileSender, ABadBooleanIsNotReceived) {
  std_msgs::msg::Bool good;
  good.data(true);
  expect_only_the_good_one<std_msgs::msg::Bool>({{0, 1, 0, 0, 7}}, good);
}

// A parameter service answers the valid request after any number of invalid ones.
TEST_F(HostileSender, BadParameterRequestsAreNotAnsweredAndChangeNothing) {
  using rcl_interfaces::srv::SetParameters;
  const auto params = node_.declare_parameters<GainParams>(
      {}, [](auto& all) -> auto& { return all; }, [](const auto&) {});
  SetParameters::Request request;
  auto& parameter = request.parameters().emplace_back();
  parameter.name("gain");
  parameter.value().type(rcl_interfaces::msg::ParameterType_Constants::PARAMETER_DOUBLE);
  parameter.value().double_value(0.5);
  const Bytes good = encoded(request);
  const rt::ServiceName<SetParameters> service{"/victim/set_parameters"};
  const auto participant = rt::Participant::shared();
  rt::Writer writer{*participant,
                    {rt::dds_request_name(service.name),
                     rt::Codec{rt::type_ref<SetParameters::Request>()}.dds_name(), rt::kDefault}};
  ASSERT_TRUE(spin_until([&] { return writer.matched() == 1; }, kTimeout, node_));
  std::vector<Bytes> bad{{},
                         {0, 1, 0, 0},
                         with_length(good, 4, 0xFFFFFFFFU),
                         with_length(good, 4, 1000),
                         with_length(good, 8, 0x7FFFFFFFU),
                         Bytes(100'000, 0xFF),
                         Bytes(300'000, 0)};
  for (std::size_t size = 1; size < good.size(); size += 5)
    bad.emplace_back(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
  for (const Bytes& bytes : bad) {
    ASSERT_TRUE(writer.write(bytes));
    node_.spin_some(0.01);
  }
  EXPECT_EQ(params->gain, 1.0);
  const auto client = node_.create_client(service);
  bool taken = false;
  client.call(
      request, [&](const auto& answer) { taken = answer.results().at(0).successful(); }, kTimeout);
  ASSERT_TRUE(spin_until([&] { return taken; }, kTimeout, node_));
  EXPECT_EQ(params->gain, 0.5);
}

TEST_F(HostileSender, NanIsReceivedBecauseTheCoresCheckNumbers) {
  double got = 0.0;
  const rt::Topic<geometry_msgs::msg::Twist> topic{"cmd_vel"};
  const auto publisher = node_.create_publisher(topic);
  const auto subscription =
      node_.create_subscription(topic, [&](const auto& message) { got = message.linear().x(); });
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, node_));
  geometry_msgs::msg::Twist message;
  message.linear().x(std::numeric_limits<double>::quiet_NaN());
  publisher.publish(message);
  EXPECT_TRUE(spin_until([&] { return std::isnan(got); }, kTimeout, node_));
}

}  // namespace
}  // namespace tandem
