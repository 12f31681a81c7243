// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/replay.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "bringup/bag/bag.hpp"
#include "bringup/drive/lockstep.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

// Plain CDR, little-endian, of values that are aligned already.
class Cdr {
 public:
  template <class T>
  Cdr& add(T value) {
    const auto at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
    return *this;
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_{0, 1, 0, 0};
};

Bytes twist(double v, double w) {
  return Cdr{}.add(v).add(0.0).add(0.0).add(0.0).add(0.0).add(w).bytes();
}

// Header of time 0 and an empty frame, two axes, one button.
Bytes joy(float left, float forward, std::int32_t deadman) {
  Cdr cdr;
  cdr.add(std::uint32_t{0}).add(std::uint32_t{0}).add(std::uint32_t{1}).add(std::uint32_t{0});
  cdr.add(std::uint32_t{2}).add(left).add(forward);
  return cdr.add(std::uint32_t{1}).add(deadman).bytes();
}

class Replay : public testing::Test {
 protected:
  Replay() {
    char name[] = "/tmp/tandem_replay_XXXXXX";
    root_ = mkdtemp(name);
    folder_ = root_ / "drive";
  }
  ~Replay() override { fs::remove_all(root_); }

  void write(const BagTopic& topic, const std::vector<std::pair<std::int64_t, Bytes>>& messages) {
    BagWriter writer{folder_};
    const int id = writer.add_topic(topic);
    for (const auto& [time, bytes] : messages) writer.write(id, time, bytes);
  }

  fs::path root_, folder_;
};

TEST_F(Replay, ReadsTheStickFromJoy) {
  write({"/a/joy", "sensor_msgs/msg/Joy"}, {{5'000'000'000, joy(-0.5F, 1.0F, 1)},
                                            {5'050'000'000, joy(0.0F, 0.5F, 1)},
                                            {5'100'000'000, joy(0.7F, 0.7F, 0)}});
  const Recording stick = recorded_stick(folder_, {});
  EXPECT_EQ(stick.t, (std::vector<double>{0.0, 0.05, 0.1}));
  ASSERT_EQ(stick.linear.size(), 3U);
  EXPECT_EQ(stick.linear[0], 1.0);
  EXPECT_NEAR(stick.angular[0], -(0.5 - 0.05) / 0.95, 1e-6);  // past the dead zone
  EXPECT_EQ(stick.linear[2], 0.0);                            // the button is released
}

TEST_F(Replay, ReadsTheStickFromThePersonsCommands) {
  write({"/cmd_vel_user", "geometry_msgs/msg/Twist"},
        {{0, twist(0.4, -0.2)}, {100'000'000, twist(2.0, 0.0)}});
  const Recording stick = recorded_stick(folder_, {});
  EXPECT_EQ(stick.t, (std::vector<double>{0.0, 0.1}));
  EXPECT_NEAR(stick.linear[0], 0.5, 1e-12);
  EXPECT_NEAR(stick.angular[0], -0.25, 1e-12);
  EXPECT_EQ(stick.linear[1], 1.0);
}

TEST_F(Replay, ReportsARecordingWithoutAStick) {
  write({"/cmd_vel", "geometry_msgs/msg/Twist"}, {{0, twist(0.4, -0.2)}});
  EXPECT_THROW((void)recorded_stick(folder_, {}), std::runtime_error);
  EXPECT_THROW((void)recorded_stick("/no/such/recording", {}), std::runtime_error);
}

TEST_F(Replay, AsksWhichOfTwoRobotsToReplayAndPlaysOnlyThatOne) {
  {
    BagWriter writer{folder_};
    const int a = writer.add_topic({"/a/joy", "sensor_msgs/msg/Joy"});
    const int b = writer.add_topic({"/b/joy", "sensor_msgs/msg/Joy"});
    for (int i = 0; i < 3; ++i) {
      writer.write(a, i * 100'000'000LL, joy(0.0F, 1.0F, 1));
      writer.write(b, i * 100'000'000LL + 50'000'000, joy(0.0F, -1.0F, 1));
    }
  }
  try {
    (void)recorded_stick(folder_, {});
    FAIL() << "mixed two hands";
  } catch (const std::runtime_error& error) {
    const std::string line = error.what();
    EXPECT_TRUE(line.starts_with(folder_.string() + ": ")) << line;
    EXPECT_NE(line.find("/a/joy, /b/joy; select one with `recording_topic`"), std::string::npos)
        << line;
  }
  EXPECT_EQ(recorded_stick(folder_, {}, "/b/joy").linear, (std::vector<double>(3, -1.0)));
  EXPECT_EQ(recorded_stick(folder_, {}, "/b/joy").t, (std::vector<double>{0.0, 0.1, 0.2}));
  EXPECT_THROW((void)recorded_stick(folder_, {}, "/c/joy"), std::runtime_error);
  Scenario scenario = load_scenario(test::source_path("bringup/scenarios/forest_task2.yaml"));
  const auto drive = with_options(
      scenario, {.driver = "replay", .recording = folder_.string(), .recording_topic = "/a/joy"});
  EXPECT_EQ(drive.recording_topic, "/a/joy");
  EXPECT_NO_THROW((void)system_of(drive, {}));
}

TEST_F(Replay, ExplainsWhatItExpectsWhenGivenAFileThatIsNotARecording) {
  try {
    (void)recorded_stick(test::source_path("bringup/scenarios/forest_task2.yaml"), {});
    FAIL() << "read";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(
        std::string{error.what()}.find("forest_task2.yaml: not a recording; expected a folder"),
        std::string::npos)
        << error.what();
  }
}

TEST_F(Replay, SkipsBytesThatAreNotAMessage) {
  write({"/joy", "sensor_msgs/msg/Joy"}, {{0, {0, 1, 0, 0, 7}}, {1, joy(0.0F, 1.0F, 1)}});
  EXPECT_EQ(recorded_stick(folder_, {}).t.size(), 1U);
}

// Full ahead for 3 s, then nobody: the same drive each time, and no longer than the stick was held.
TEST_F(Replay, DrivesWhatWasRecorded) {
  std::vector<std::pair<std::int64_t, Bytes>> messages;
  for (int i = 0; i < 60; ++i) messages.emplace_back(i * 50'000'000LL, joy(0.0F, 1.0F, 1));
  write({"/joy", "sensor_msgs/msg/Joy"}, messages);
  Scenario scenario = load_scenario(test::source_path("bringup/scenarios/forest_task2.yaml"));
  scenario.duration = 6.0;
  DriveOptions options;
  options.method = "manual";
  options.driver = "replay";
  options.lockstep = true;
  EXPECT_THROW((void)with_options(scenario, options), std::invalid_argument);  // which recording?
  options.recording = folder_;
  const DriveLog drive = drive_in_lockstep(scenario, options),
                 again = drive_in_lockstep(scenario, options);
  EXPECT_EQ(drive.result.driver, "replay");
  EXPECT_GT(drive.result.path_length_m, 1.8);
  EXPECT_LT(drive.result.path_length_m, 3.2);
  ASSERT_EQ(drive.track.size(), again.track.size());
  EXPECT_EQ(drive.track.back().X_MB, again.track.back().X_MB);
  EXPECT_EQ(drive.track.back().twist.v, 0.0);
}

// Whatever the dead zone, the person's commands are the recorded ones.
TEST_F(Replay, RepeatsTheRecordedCommands) {
  write({"/cmd_vel_user", "geometry_msgs/msg/Twist"},
        {{0, twist(0.2, -0.04)}, {2'000'000'000, twist(0.2, -0.04)}});
  DriveOptions options;
  options.method = "manual";
  options.driver = "replay";
  options.recording = folder_;
  options.lockstep = true;
  for (const char* deadzone : {"0.05", "0.3"}) {
    Scenario scenario = load_scenario(test::source_path("bringup/scenarios/forest_task2.yaml"));
    scenario.duration = 1.0;
    scenario.parameters["teleop"]["deadzone"] = {deadzone, "this test"};
    const DriveLog drive = drive_in_lockstep(scenario, options);
    ASSERT_FALSE(drive.track.empty());
    EXPECT_NEAR(drive.track.back().user.v, 0.2, 1e-6) << deadzone;
    EXPECT_NEAR(drive.track.back().user.w, -0.04, 1e-6) << deadzone;
  }
}

}  // namespace
}  // namespace tandem
