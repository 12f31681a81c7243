// SPDX-License-Identifier: Apache-2.0
// The same drive measured live and from its recording.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/private_domain.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string kScenario = TANDEM_SOURCE_DIR "/bringup/scenarios/forest_task2.yaml";

class MetricsProgram : public ::testing::Test {
 protected:
  MetricsProgram() { fs::create_directories(folder_); }
  ~MetricsProgram() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_ / name).string();
  }
  [[nodiscard]] json read(const std::string& name) const {
    std::ifstream in{file(name)};
    return json::parse(in);
  }
  static int run(const std::vector<std::string>& words) {
    test::ChildProcess program{"../tandem", words};
    return program.wait(150.0).value_or(-1);
  }

  fs::path folder_ = fs::temp_directory_path() / ("tandem_metrics_" + std::to_string(getpid()));
};

TEST_F(MetricsProgram, MeasuresARecordingAsTheDriveWasMeasured) {
  {
    test::ChildProcess record{"../tandem", {"record", "-o", file("bag")}};
    ASSERT_EQ(
        run({"scenario", kScenario, "--method", "safety_filter", "--json", file("live.json")}), 0);
    record.send(SIGINT);
    ASSERT_EQ(record.wait(30.0), 0);
  }
  ASSERT_EQ(run({"metrics", file("bag"), "--scenario", kScenario, "--method", "safety_filter",
                 "--json", file("recorded.json")}),
            0);
  const json live = read("live.json").at(0), recorded = read("recorded.json");
  for (const char* key : {"scenario", "method", "driver", "reached", "collisions"})
    EXPECT_EQ(live.at(key), recorded.at(key)) << key;
  // The recording hears the same messages, the first ones and the last ones a moment apart.
  const auto differ = [&](const char* key) {
    return std::abs(live.at(key).get<double>() - recorded.at(key).get<double>());
  };
  EXPECT_LE(differ("time_to_goal_s"), 0.5);
  EXPECT_LE(differ("path_length_m"), 0.1);
  EXPECT_LE(differ("path_ratio"), 0.02);
  EXPECT_LE(differ("min_clearance_m"), 0.01);
  EXPECT_LE(differ("mean_clearance_m"), 0.05);
  EXPECT_LE(differ("agreement_direction"), 0.05);
  EXPECT_LE(differ("agreement_magnitude"), 0.05);
}

TEST_F(MetricsProgram, SaysWhatIsWrongWithARecording) {
  std::ofstream{file("none.db3")} << "no recording";
  const test::CapturedLog log;
  EXPECT_EQ(run({"metrics", file("none.db3"), "--scenario", kScenario}), 1);
  EXPECT_EQ(log.lines("tandem: "), 1) << log.text();
  EXPECT_EQ(run({"metrics", "/nowhere", "--scenario", kScenario}), 1);
}

}  // namespace
}  // namespace tandem
