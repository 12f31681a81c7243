// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/foxglove_protocol.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include <vector>

#include "dashboard/damaged.hpp"

namespace tandem::foxglove {
namespace {

template <class T>
T parsed(const std::string& frame) {
  const Request request = parse_text(frame);
  const auto* as = std::get_if<T>(&request);
  EXPECT_NE(as, nullptr) << frame;
  return as != nullptr ? *as : T{};
}

Request binary(const Bytes& frame) { return parse_binary(frame); }
std::string deep_list(std::size_t depth) {
  return std::string(depth, '[') + std::string(depth, ']');
}

bool is_malformed(const Request& request) { return std::holds_alternative<Malformed>(request); }

TEST(FoxgloveText, ReadsASubscription) {
  const auto request = parsed<Subscribe>(
      R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":4294967295,"channelId":5}]})");
  ASSERT_EQ(request.all.size(), 2U);
  EXPECT_EQ(request.all[0].channel, 3U);
  EXPECT_EQ(request.all[1].subscription, 4294967295U);
}

TEST(FoxgloveText, ReadsWhatAClientWillPublish) {
  const auto request = parsed<Advertise>(
      R"({"op":"advertise","channels":[{"id":2,"topic":"/joy","encoding":"cdr","schemaName":"sensor_msgs/msg/Joy"}]})");
  ASSERT_EQ(request.all.size(), 1U);
  EXPECT_EQ(request.all[0].topic, "/joy");
  EXPECT_EQ(request.all[0].schema_name, "sensor_msgs/msg/Joy");
}

TEST(FoxgloveText, ReadsParameterRequests) {
  EXPECT_EQ(parsed<GetParameters>(R"({"op":"getParameters","parameterNames":[],"id":"a"})").id,
            "a");
  const auto set = parsed<SetParameters>(
      R"({"op":"setParameters","parameters":[{"name":"/teleop.leash","value":1.5}]})");
  ASSERT_EQ(set.all.size(), 1U);
  EXPECT_EQ(set.all[0].value, 1.5);
}

TEST(FoxgloveText, RefusesInvalidRequests) {
  for (const char* frame :
       {"", "{", "null", "[]", "3", "\"op\"", R"({})", R"({"op":3})", R"({"op":"fly"})",
        R"({"op":"subscribe"})", R"({"op":"subscribe","subscriptions":3})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":3}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":3}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":3}]})",
        R"({"op":"advertise","channels":[{"id":2,"topic":7,"encoding":"cdr","schemaName":""}]})",
        R"({"op":"setParameters","parameters":[{"value":1}]})", "{\"op\":\"\xff\"}"})
    EXPECT_TRUE(is_malformed(parse_text(frame))) << frame;
}

TEST(FoxgloveText, SurvivesDeepNesting) {
  const std::string deep(60'000, '[');
  EXPECT_TRUE(is_malformed(parse_text(R"({"op": "setParameters", "parameters": [{"name": "a.b", )"
                                      R"("value": )" +
                                      deep_list(200'000) + "}]}")));
  EXPECT_FALSE(is_malformed(parse_text(R"({"op": "setParameters", "parameters": [{"name": "a.b", )"
                                       R"("value": )" +
                                       deep_list(10) + "}]}")));
  EXPECT_TRUE(is_malformed(parse_text(deep)));
  EXPECT_TRUE(is_malformed(parse_text(deep + std::string(60'000, ']'))));
}

TEST(FoxgloveBinary, ReadsAMessage) {
  const Request request = binary({1, 7, 0, 0, 0, 0xaa, 0xbb});
  ASSERT_TRUE(std::holds_alternative<Message>(request));
  EXPECT_EQ(std::get<Message>(request).channel, 7U);
  EXPECT_EQ(std::get<Message>(request).payload, (Bytes{0xaa, 0xbb}));
}

TEST(FoxgloveBinary, ReadsAServiceCall) {
  const Request request = binary({2, 1, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0, 'c', 'd', 'r', 0xcc});
  ASSERT_TRUE(std::holds_alternative<ServiceCall>(request));
  const auto& call = std::get<ServiceCall>(request);
  EXPECT_EQ(call.call, 9U);
  EXPECT_EQ(call.encoding, "cdr");
  EXPECT_EQ(call.payload, Bytes{0xcc});
}

TEST(FoxgloveBinary, RefusesEveryShortenedServiceCall) {
  const Bytes whole{2, 1, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0, 'c', 'd', 'r'};
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_TRUE(is_malformed(binary(Bytes(whole.begin(), whole.begin() + static_cast<long>(size)))))
        << size;
  EXPECT_TRUE(is_malformed(binary({2, 1, 0, 0, 0, 9, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 'c'})));
}

// Any input is parsed as a request or rejected as malformed; nothing is thrown.
TEST(Foxglove, TakesAnyBytes) {
  const std::vector<std::string> frames{
      R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":1,"channelId":4}]})",
      R"({"op":"unsubscribe","subscriptionIds":[0,4294967295]})",
      R"({"op":"advertise","channels":[{"id":2,"topic":"/joy","encoding":"cdr","schemaName":"a/msg/B"}]})",
      R"({"op":"unadvertise","channelIds":[2]})",
      R"({"op":"getParameters","parameterNames":["/a.b"],"id":"x"})",
      R"({"op":"setParameters","parameters":[{"name":"/a.b","value":[1,-2.5e3,true,"\u00e9"]}]})",
      R"({"op":"subscribeParameterUpdates","parameterNames":["/a.b"]})",
      std::string("\1\7\0\0\0\xaa\xbb", 7),
      std::string("\2\1\0\0\0\11\0\0\0\3\0\0\0cdr\xcc", 17)};
  std::mt19937 random{7};
  int sound = 0;
  for (int i = 0; i < 100'000; ++i) {
    const std::string frame = test::damaged(frames, random);
    Request request;
    EXPECT_NO_THROW(request = parse_text(frame));
    sound += is_malformed(request) ? 0 : 1;
    EXPECT_NO_THROW(request = binary(Bytes(frame.begin(), frame.end())));
    sound += is_malformed(request) ? 0 : 1;
  }
  EXPECT_GT(sound, 10'000);  // most damage is found where frames are nearly sound
}

TEST(Foxglove, WritesFramesThatOthersRead) {
  EXPECT_EQ(message_head(0x01020304, 0x1122334455667788),
            std::string("\x01\x04\x03\x02\x01"
                        "\x88\x77\x66\x55\x44\x33\x22\x11"));
  EXPECT_EQ(time(1), std::string("\x02\x01\0\0\0\0\0\0\0", 9));
  EXPECT_EQ(response_head({1, 2, "cdr", {}}), std::string("\x03\1\0\0\0\2\0\0\0\3\0\0\0cdr", 16));
  const auto frame = json::parse(status(Level::kError, "\xff is no UTF-8"));
  EXPECT_EQ(frame.at("level"), 2);
}

double seconds_to_parse(int objects) {
  std::string frame = R"({"op":"x","y":[)";
  for (int i = 0; i < objects; ++i) frame += R"({"":[]},)";
  frame.back() = ']';
  frame += '}';
  double best = 1e9;
  for (int i = 0; i < 7; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    (void)parse_text(frame);
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

TEST(Foxglove, TakesTimeInProportionToTheFrame) {
  EXPECT_LT(seconds_to_parse(16'000), 64.0 * seconds_to_parse(1000));  // 256 times if quadratic
}

}  // namespace
}  // namespace tandem::foxglove
