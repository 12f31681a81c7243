// SPDX-License-Identifier: Apache-2.0
// Tests a node's log lines on /rosout, and the level that rqt_console sets.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using rcl_interfaces::msg::Log;
using rcl_interfaces::srv::GetLoggerLevels;
using rcl_interfaces::srv::SetLoggerLevels;
using test::spin_until;

using test::kTimeout;
constexpr rt::QoS kRosOut{rt::Reliability::kReliable, rt::Durability::kTransientLocal, 1000};

class RosOut : public testing::Test {
 protected:
  // The first received line with this text.
  std::optional<Log> heard(const std::string& text) {
    const auto found = [&] {
      return std::find_if(lines_.begin(), lines_.end(),
                          [&](const Log& line) { return line.msg() == text; });
    };
    if (!spin_until([&] { return found() != lines_.end(); }, kTimeout, node_, console_))
      return std::nullopt;
    return *found();
  }

  std::vector<std::string> texts() const {
    std::vector<std::string> all;
    for (const Log& line : lines_) all.push_back(line.msg());
    return all;
  }

  rt::Node node_{rt::NodeOptions{.name = "gate", .ns = "/robot"}};
  rt::Node console_{rt::NodeOptions{.name = "console", .serves_tools = false}};
  std::vector<Log> lines_;
  rt::Subscription subscription_ = console_.create_subscription(
      rt::Topic<Log>{"/rosout", kRosOut}, [this](const Log& line) { lines_.push_back(line); });
};

TEST_F(RosOut, CarriesALineWithItsPlaceInTheSources) {
  const int line = __LINE__ + 1;
  node_.log().warn("margin {} is small", 0.25);
  const auto log = heard("margin 0.25 is small");
  ASSERT_TRUE(log);
  EXPECT_EQ(log->level(), 30);
  EXPECT_EQ(log->name(), "robot.gate");
  EXPECT_TRUE(log->file().ends_with("rosout_test.cpp")) << log->file();
  EXPECT_EQ(log->function(), __func__);
  EXPECT_EQ(log->line(), static_cast<std::uint32_t>(line));
  EXPECT_NEAR(rt::to_seconds(log->stamp()), 1e-9 * static_cast<double>(rt::system_nanoseconds()),
              2.0 * kTimeout);
}

TEST_F(RosOut, CarriesTheLevelOfEachLine) {
  node_.log().info("as usual");
  node_.log().error_every(1.0, "not at all");
  ASSERT_TRUE(heard("as usual") && heard("not at all"));
  EXPECT_EQ(heard("as usual")->level(), 20);
  EXPECT_EQ(heard("not at all")->level(), 40);
  EXPECT_TRUE(heard("not at all")->file().ends_with("rosout_test.cpp"));
}

TEST_F(RosOut, LogsWhatIsMissingFirstAsInfoThenAsAWarning) {
  for (const char* what : {"no map", "no goal", "no map"})
    node_.log().missing_every(10.0, "standing: {}", what);
  ASSERT_TRUE(heard("standing: no map") && heard("standing: no goal"));
  EXPECT_EQ(heard("standing: no map")->level(), 20);
  const auto warned = [&] {
    node_.log().missing_every(0.1, "standing: {}", "no people");
    return std::any_of(lines_.begin(), lines_.end(),
                       [](const Log& line) { return line.level() == 30; });
  };
  EXPECT_TRUE(spin_until(warned, kTimeout, node_, console_));
  EXPECT_EQ(std::ranges::count(texts(), "standing: no map"), 1);
}

TEST_F(RosOut, DeliversEarlierLinesToALateSubscription) {
  node_.log().info("before");
  std::string late;
  rt::Node other{rt::NodeOptions{.name = "late", .serves_tools = false}};
  const auto subscription = other.create_subscription(rt::Topic<Log>{"/rosout", kRosOut},
                                                      [&](const Log& line) { late = line.msg(); });
  EXPECT_TRUE(spin_until([&] { return late == "before"; }, kTimeout, other));
}

TEST_F(RosOut, CarriesLinesOfOtherThreadsInTheirOrder) {
  const auto log = [&](char name) {
    for (int i = 0; i < 20; ++i) node_.log().info("{}{:02}", name, i);
  };
  std::thread a{log, 'a'}, b{log, 'b'};
  a.join();
  b.join();
  ASSERT_TRUE(heard("a19") && heard("b19"));
  for (const char name : {'a', 'b'}) {
    auto mine = texts();
    std::erase_if(mine, [&](const auto& text) { return text[0] != name; });
    EXPECT_EQ(mine.size(), 20U);
    EXPECT_TRUE(std::is_sorted(mine.begin(), mine.end()));
  }
}

class LoggerLevels : public RosOut {
 protected:
  bool set(const std::string& logger, std::uint32_t level) {
    SetLoggerLevels::Request request;
    auto& wanted = request.levels().emplace_back();
    wanted.name(logger);
    wanted.level(level);
    std::optional<bool> answer;
    const auto client =
        console_.create_client(rt::ServiceName<SetLoggerLevels>{"/robot/gate/set_logger_levels"});
    client.call(
        request, [&](const auto& response) { answer = response.results().at(0).successful(); },
        kTimeout);
    EXPECT_TRUE(spin_until([&] { return answer.has_value(); }, kTimeout, node_, console_));
    return answer.value_or(false);
  }

  std::uint32_t get(const std::string& logger) {
    GetLoggerLevels::Request request;
    request.names({logger});
    std::optional<std::uint32_t> level;
    const auto client =
        console_.create_client(rt::ServiceName<GetLoggerLevels>{"/robot/gate/get_logger_levels"});
    client.call(
        request, [&](const auto& response) { level = response.levels().at(0).level(); }, kTimeout);
    EXPECT_TRUE(spin_until([&] { return level.has_value(); }, kTimeout, node_, console_));
    return level.value_or(99);
  }
};

TEST_F(LoggerLevels, LetDebugLinesThroughAndHoldThemBackAgain) {
  EXPECT_EQ(get("robot.gate"), 20U);
  node_.log().debug("unheard");
  EXPECT_TRUE(set("robot.gate", 10));
  EXPECT_EQ(get("robot.gate"), 10U);
  node_.log().debug("heard");
  EXPECT_TRUE(set("robot.gate", 0));  // the process's again
  EXPECT_EQ(get("robot.gate"), 20U);
  node_.log().debug("unheard");
  EXPECT_TRUE(set("robot.gate", 40));
  node_.log().warn("unheard");
  node_.log().error("the last");
  ASSERT_TRUE(heard("the last"));
  EXPECT_EQ(texts(), (std::vector<std::string>{"heard", "the last"}));
}

TEST_F(LoggerLevels, RefuseOtherLoggersAndInvalidLevels) {
  EXPECT_FALSE(set("nobody", 10));
  EXPECT_FALSE(set("robot.gate", 25));
  EXPECT_EQ(get("robot.gate"), 20U);
  EXPECT_EQ(get("nobody"), 0U);
}

}  // namespace
}  // namespace tandem
