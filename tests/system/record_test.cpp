// SPDX-License-Identifier: Apache-2.0
// `tandem record` and `tandem play` in their own processes.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bringup/bag/bag.hpp"
#include "support/child_process.hpp"
#include "system/one_component.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kForeignHash =
    "RIHS01_00000000000000000000000000000000000000000000000000000000000000aa";

// How many messages of each topic a recording holds.
std::map<std::string, int> messages_by_topic(const fs::path& folder) {
  std::map<std::string, int> counts;
  BagReader bag{folder};
  for (BagMessage message; bag.next(message);) ++counts[bag.topics()[message.topic].name];
  return counts;
}

// The recorded std_msgs/Float64, in their order.
std::vector<double> values_of(const fs::path& folder) {
  std::vector<double> values;
  BagReader bag{folder};
  for (BagMessage message; bag.next(message);)
    if (const auto number = rt::decode<std_msgs::msg::Float64>(message.bytes))
      values.push_back(number->data());
  return values;
}

class Recording : public testing::Test {
 protected:
  Recording() {
    char name[] = "/tmp/tandem_record_XXXXXX";
    root_ = mkdtemp(name);
    folder_ = root_ / "drive";
  }
  ~Recording() override { fs::remove_all(root_); }

  template <class Predicate>
  bool wait_until(Predicate predicate) {
    return spin_until(predicate, kLongTimeout, node_);
  }

  // The recorder's answer to one request.
  template <class S>
  typename S::Response ask(const char* service, const typename S::Request& request = {}) {
    const auto client = node_.create_client(rt::ServiceName<S>{service});
    std::optional<typename S::Response> answer;
    client.call(
        request, [&](const auto& response) { answer = response; }, kLongTimeout);
    EXPECT_TRUE(wait_until([&] { return answer.has_value(); })) << service;
    return answer.value_or(typename S::Response{});
  }
  // The error of a request for a recording in `uri`; empty if it has begun.
  std::string error_of_recording(const fs::path& uri) {
    rosbag2_interfaces::srv::Record_Request request;
    request.uri(uri.string());
    const auto answer = ask<rosbag2_interfaces::srv::Record>("/tandem_record/record", request);
    EXPECT_EQ(answer.return_code(), answer.error_string().empty() ? 0 : 1);
    return answer.error_string();
  }

  fs::path root_, folder_;
  rt::Node node_{"tester"};
};

TEST_F(Recording, PlaysBackRecordedMessagesOfKnownAndUnknownTypes) {
  const rt::Topic<std_msgs::msg::Float64> kNumbers{"numbers"};
  const std::vector<std::uint8_t> foreign_bytes{0, 1, 0, 0, 4, 0, 0, 0, 9, 9, 9, 9};
  {
    const auto numbers = node_.create_publisher(kNumbers);
    const auto foreign =
        node_.create_generic_publisher("odd", "alien_msgs/msg/Odd", rt::kSensorData, kForeignHash);
    ChildProcess record{"../tandem", {"record", "-o", folder_}};
    ASSERT_TRUE(wait_until([&] { return numbers.matched() == 1 && foreign.matched() == 1; }));
    for (int i = 0; i < 10; ++i) {
      std_msgs::msg::Float64 msg;
      msg.data(i);
      numbers.publish(msg);
    }
    // It has heard all when what it commits, once a second, holds all. Best effort may be lost:
    // the odd ones go on until one is in.
    ASSERT_TRUE(wait_until([&] {
      foreign.publish(foreign_bytes);
      const auto heard = messages_by_topic(folder_);
      return heard.count("/numbers") && heard.at("/numbers") == 10 && heard.count("/odd");
    }));
    record.send(SIGINT);
    ASSERT_EQ(record.wait(kLongTimeout), 0);
  }
  std::vector<double> got;
  std::vector<std::vector<std::uint8_t>> got_foreign;
  const auto numbers =
      node_.create_subscription(kNumbers, [&](const auto& msg) { got.push_back(msg.data()); });
  const auto foreign =
      node_.create_generic_subscription("odd", "alien_msgs/msg/Odd", rt::kSensorData,
                                        [&](const auto& bytes) { got_foreign.push_back(bytes); });
  // Until both are matched, however slow the machine, and again for what best effort may lose.
  ChildProcess play{"../tandem",
                    {"play", folder_, "--topics", "/numbers", "/odd", "--wait", "60", "--loop"}};
  ASSERT_TRUE(wait_until([&] { return got.size() >= 10 && !got_foreign.empty(); }))
      << got.size() << " " << got_foreign.size();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(got[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(got_foreign.front(), foreign_bytes);
  play.send(SIGTERM);
  EXPECT_EQ(play.wait(kLongTimeout), 0);
}

// Three types under one name are more than a process can hear; a DDS program's name may be any.
TEST_F(Recording, AnUnusableTopicDoesNotAffectOthers) {
  const fs::path odd = root_ / "odd";
  {
    BagWriter writer{odd};
    const int bad = writer.add_topic({"/foo/", "std_msgs/msg/Bool"});
    const int none = writer.add_topic({"/x", "NoType"});
    const int flag = writer.add_topic({"/many", "std_msgs/msg/Bool"});
    for (int i = 0; i < 200; ++i)
      for (const int topic : {bad, none, flag})
        writer.write(topic, 1 + 20'000'000 * i, {0, 1, 0, 0, 1, 0, 0, 0});
  }
  const auto words = node_.create_publisher(rt::Topic<std_msgs::msg::String>{"/many"});
  const auto numbers = node_.create_publisher(rt::Topic<std_msgs::msg::Float64>{"/many"});
  ChildProcess play{"../tandem", {"play", odd, "--wait", "0", "--loop"}};
  ChildProcess record{"../tandem", {"record", "-o", folder_}};
  const auto other = node_.create_publisher(rt::Topic<std_msgs::msg::Float64>{"/other"});
  ASSERT_TRUE(wait_until([&] { return other.matched() == 1; }));
  ASSERT_TRUE(wait_until([&] {
    words.publish({});
    numbers.publish({});
    other.publish({});
    const auto heard = messages_by_topic(folder_);
    return heard.contains("/many") && heard.contains("/other");
  }));
  record.send(SIGINT);
  EXPECT_EQ(record.wait(kLongTimeout), 0);
  play.send(SIGINT);
  EXPECT_EQ(play.wait(kLongTimeout), 0);
}

TEST_F(Recording, AcceptsNamesWithoutASlashAndReportsSilentTopics) {
  const auto numbers = node_.create_publisher(rt::Topic<std_msgs::msg::Float64>{"/numbers"});
  ChildProcess record{"../tandem", {"record", "numbers", "/numbres", "-o", folder_}};
  ASSERT_TRUE(wait_until([&] { return numbers.matched() == 1; }));
  ASSERT_TRUE(wait_until([&] {
    numbers.publish({});
    return messages_by_topic(folder_).contains("/numbers");
  }));
  record.send(SIGINT);
  EXPECT_EQ(record.wait(kLongTimeout), 0);
  ChildProcess play{"../tandem", {"play", folder_, "--topics", "/numbres"}};
  EXPECT_EQ(play.wait(kLongTimeout), 1);
}

// As rosbag2's recorder of Jazzy and Kilted.
TEST_F(Recording, IsPausedEndedAndBegunAgainByServices) {
  namespace srv = rosbag2_interfaces::srv;
  const auto numbers = node_.create_publisher(rt::Topic<std_msgs::msg::Float64>{"/numbers"});
  const auto publish = [&](double value) {
    std_msgs::msg::Float64 msg;
    msg.data(value);
    numbers.publish(msg);
  };
  const auto is_paused = [&] { return ask<srv::IsPaused>("/tandem_record/is_paused").paused(); };
  const auto is_recorded_in = [&](const fs::path& folder, double value) {
    return wait_until([&] {
      publish(value);
      return messages_by_topic(folder).contains("/numbers");
    });
  };
  ChildProcess record{"../tandem", {"record", "-o", folder_, "/numbers"}};
  ASSERT_TRUE(wait_until([&] { return numbers.matched() == 1; }));
  ASSERT_TRUE(is_recorded_in(folder_, 1.0));
  EXPECT_FALSE(is_paused());
  ask<srv::Pause>("/tandem_record/pause");
  publish(2.0);
  EXPECT_TRUE(is_paused());  // received after the 2
  ask<srv::Resume>("/tandem_record/resume");
  EXPECT_FALSE(is_paused());
  publish(3.0);
  EXPECT_FALSE(is_paused());  // received after the 3
  EXPECT_NE(error_of_recording("second"), "") << "one is running";
  ask<srv::Stop>("/tandem_record/stop");
  ASSERT_TRUE(wait_until([&] { return numbers.matched() == 0; }));
  const auto values = values_of(folder_);
  EXPECT_EQ(values.front(), 1.0);
  EXPECT_EQ(std::count(values.begin(), values.end(), 2.0), 0);
  EXPECT_EQ(values.back(), 3.0);

  EXPECT_NE(error_of_recording(""), "");
  EXPECT_NE(error_of_recording(folder_), "") << "it exists";
  EXPECT_NE(error_of_recording("/tmp/tandem_elsewhere"), "");
  EXPECT_NE(error_of_recording("../elsewhere"), "");
  EXPECT_EQ(error_of_recording("file://" + (root_ / "second").string()), "");
  ASSERT_TRUE(is_recorded_in(root_ / "second", 4.0));
  record.send(SIGINT);
  EXPECT_EQ(record.wait(kLongTimeout), 0);
  for (const double value : values_of(root_ / "second")) EXPECT_EQ(value, 4.0);
}

// Each of three publishers kept its last message, so the one that plays them keeps all three.
TEST_F(Recording, GivesALateSubscriberTheStaticTransformsOfEveryPublisher) {
  const rt::Topic<std_msgs::msg::Float64> kStatic{
      "/three/tf_static", {rt::Reliability::kReliable, rt::Durability::kTransientLocal, 100}};
  const std::vector<std::uint8_t> bytes{0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  {
    BagWriter writer{folder_};
    const int latched = writer.add_topic({kStatic.name, "std_msgs/msg/Float64", rt::kLatched});
    const int flag = writer.add_topic({"/later", "std_msgs/msg/Float64"});
    for (int i = 0; i < 3; ++i) writer.write(latched, i, bytes);
    for (std::int64_t i = 1; i < 600; ++i) writer.write(flag, 100'000'000 * i, bytes);
  }
  ChildProcess play{"../tandem", {"play", folder_, "--wait", "0"}};
  int later = 0, transforms = 0;
  const auto later_in = node_.create_subscription(rt::Topic<std_msgs::msg::Float64>{"/later"},
                                                  [&](const auto&) { ++later; });
  ASSERT_TRUE(wait_until([&] { return later > 0; }));
  const auto transforms_in = node_.create_subscription(kStatic, [&](const auto&) { ++transforms; });
  EXPECT_TRUE(wait_until([&] { return transforms == 3; })) << transforms;
  play.send(SIGINT);
  EXPECT_EQ(play.wait(kLongTimeout), 0);
}

TEST_F(Recording, DoesNotWaitForTheClockThatWasSetMeanwhile) {
  const std::vector<std::uint8_t> bytes{0, 1, 0, 0, 1, 0, 0, 0};
  {
    BagWriter writer{folder_};
    const int flag = writer.add_topic({"/flag", "std_msgs/msg/Bool"});
    writer.write(flag, 0, bytes);
    writer.write(flag, 1'700'000'000'000'000'000, bytes);
  }
  ChildProcess play{"../tandem", {"play", folder_, "--wait", "0"}};
  EXPECT_EQ(play.wait(kLongTimeout), 0);
}

TEST_F(Recording, RemapsAndRepeatsWhatItPlays) {
  {
    BagWriter writer{folder_};
    const int topic = writer.add_topic({"/stop", "std_msgs/msg/Bool"});
    writer.write(topic, 0, {0, 1, 0, 0, 1, 0, 0, 0});
    writer.write(topic, 20'000'000, {0, 1, 0, 0, 0, 0, 0, 0});
  }
  int on = 0, off = 0;
  const auto subscription = node_.create_subscription(
      rt::Topic<std_msgs::msg::Bool>{"/halt"}, [&](const auto& msg) { ++(msg.data() ? on : off); });
  ChildProcess play{"../tandem",
                    {"play", folder_, "--loop", "--rate", "2", "--ros-args", "-r", "/stop:=/halt"}};
  ASSERT_TRUE(wait_until([&] { return on >= 3 && off >= 2; }));
  play.send(SIGTERM);
  EXPECT_EQ(play.wait(kLongTimeout), 0);
}

}  // namespace
}  // namespace tandem::test
