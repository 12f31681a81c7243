// SPDX-License-Identifier: Apache-2.0
// Writes recordings of a base with known delays and reads what `tandem measure` prints of them.
#include "bringup/cli/measure_command.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include "bringup/bag/bag.hpp"
#include "support/temporary_folder.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;

constexpr std::int64_t kStart = 1'790'000'000'000'000'000, kMillisecond = 1'000'000;  // [ns]

class Measure : public testing::Test {
 protected:
  // Steps of 1 s at 40 Hz, forward and turning; odometry at 50 Hz, whose stamps are `age` [ms] old.
  void record(bool with_steps, int age) const {
    constexpr int kDelay = 60;     // [ms] until a command acts
    constexpr double kLag = 80.0;  // [ms]
    BagWriter bag{bag_};
    const int cmd_vel = bag.add_topic({"/cmd_vel", "geometry_msgs/msg/Twist", {}});
    const int odom = bag.add_topic({"/odom", "nav_msgs/msg/Odometry", {}});
    std::deque<Twist2> on_the_way;
    Twist2 twist;
    for (int ms = 0; ms < 16'000; ++ms) {
      const bool forward = ms / 1000 % 4 == 0, turns = ms / 1000 % 4 == 2;
      const Twist2 command = with_steps ? Twist2{forward ? 0.6 : 0.0, turns ? 0.8 : 0.0} : Twist2{};
      on_the_way.push_back(command);
      if (on_the_way.size() > kDelay) {
        twist.v += (on_the_way.front().v - twist.v) / kLag;
        twist.w += (on_the_way.front().w - twist.w) / kLag;
        on_the_way.pop_front();
      }
      const std::int64_t now = kStart + ms * kMillisecond;
      if (ms % 25 == 0) bag.write(cmd_vel, now, rt::encode(to_msg(command)));
      if (ms % 20 != 0) continue;
      nav_msgs::msg::Odometry odometry;
      odometry.header().stamp(rt::to_stamp(now - age * kMillisecond));
      odometry.twist().twist(to_msg(twist));
      bag.write(odom, now, rt::encode(odometry));
    }
  }
  [[nodiscard]] std::string measured(std::vector<std::string> options = {}) const {
    CLI::App program{"tandem"};
    add_measure_command(program);
    std::vector<std::string> words{"measure", bag_};
    words.insert(words.end(), options.begin(), options.end());
    std::reverse(words.begin(), words.end());  // as CLI11 wants them
    testing::internal::CaptureStdout();
    try {
      program.parse(words);
    } catch (const std::exception& error) {
      return testing::internal::GetCapturedStdout() + error.what();
    }
    return testing::internal::GetCapturedStdout();
  }
  static double value_of(const std::string& name, const std::string& text) {
    const auto at = text.find("    " + name + ": ");
    return at == std::string::npos ? NAN : std::stod(text.substr(at + name.size() + 6));
  }

  test::TemporaryFolder folder_;
  std::string bag_ = (folder_.path() / "bag").string();
};

TEST_F(Measure, PrintsTheParametersOfTheBase) {
  record(true, 20);
  const std::string text = measured();
  EXPECT_NEAR(value_of("motor_lag", text), 0.080, 0.005) << text;
  EXPECT_NEAR(value_of("sensor_delay", text), 0.020, 0.001);
  EXPECT_NEAR(value_of("command_delay", text), 0.040, 0.005) << "without the age of odometry";
  EXPECT_NEAR(value_of("delay", text), 0.140, 0.008);
  EXPECT_GT(value_of("a_brake", text), 1.0);
  EXPECT_GT(value_of("alpha_brake", text), 1.0);
}

TEST_F(Measure, TellsThatTheClocksDiffer) {
  record(true, -500);
  const std::string text = measured();
  EXPECT_NE(text.find("sensor_delay: unknown, because the clocks"), std::string::npos) << text;
  EXPECT_NEAR(value_of("command_delay", text), 0.060, 0.005);
}

TEST_F(Measure, RefusesARecordingWithoutSteps) {
  record(false, 20);
  EXPECT_NE(measured().find("the commands hardly change; record steps"), std::string::npos);
}

TEST_F(Measure, NamesTheTopicThatIsMissing) {
  record(true, 20);
  EXPECT_NE(measured({"--odom", "/wheel_odom"}).find("contains no /wheel_odom; record it, or name"),
            std::string::npos);
}

}  // namespace
}  // namespace tandem
