// SPDX-License-Identifier: Apache-2.0
// Recordings in MCAP beside PyPI's mcap, mcap-ros2-support and rosbags, in both directions.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "bringup/bag/lz4.hpp"
#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/temporary_folder.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeout = 150.0;  // [s]

const fs::path kPython = test::peers_path("python/bin/python");
const std::string kScript = test::source_path("tests/interop/python_peer/recording.py");
const std::string kScenario = test::source_path("bringup/scenarios/forest_task2.yaml");

class Recordings : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kPython)) GTEST_SKIP() << kPython << " was not built";
  }

  // A drive of a few seconds over DDS.
  void record() const {
    test::ChildProcess recorder{"../tandem", {"record", "-o", bag_}};
    const double end = runtime::steady_seconds() + 30.0;
    while (!fs::exists(bag_)) {
      ASSERT_LT(runtime::steady_seconds(), end) << "nobody records";
      std::this_thread::yield();
    }
    test::ChildProcess drive{"../tandem", {"scenario", kScenario, "--method", "safety_filter"}};
    ASSERT_EQ(drive.wait(kTimeout), 0);
    recorder.send(SIGINT);
    ASSERT_EQ(recorder.wait(30.0), 0);
  }
  static int python(const std::vector<std::string>& words) {
    std::vector<std::string> all{kScript};
    all.insert(all.end(), words.begin(), words.end());
    return test::ChildProcess{kPython, all}.wait(kTimeout).value_or(-1);
  }
  // Empty if the recording cannot be measured.
  [[nodiscard]] std::string measure(const std::string& bag) const {
    const std::string json = folder_.path() / "measures.json";
    fs::remove(json);
    test::ChildProcess metrics{
        "../tandem",
        {"metrics", bag, "--scenario", kScenario, "--method", "safety_filter", "--json", json}};
    (void)metrics.wait(kTimeout);
    std::ifstream in{json};
    return {std::istreambuf_iterator<char>(in), {}};
  }

  const test::PrivateDomain domain_;
  const test::TemporaryFolder folder_;
  const std::string bag_ = folder_.path() / "drive", rewritten_ = folder_.path() / "rewritten";
};

TEST_F(Recordings, AreReadAlikeByAllAndMeasuredAlikeHoweverTheyWereWritten) {
  record();
  EXPECT_EQ(python({"compare", bag_}), 0);
  ASSERT_EQ(python({"rewrite", bag_, rewritten_}), 0);
  const std::string measures = measure(bag_);
  ASSERT_NE(measures, "");
  const test::CapturedLog log;
  for (const char* form : {"rosbags", "zstd", "plain", "unindexed", "unchunked", "cut"})
    EXPECT_EQ(measure(rewritten_ + "/" + form), measures) << form;
  EXPECT_EQ(log.lines("cut/a.mcap: has no end"), 1) << log.text();
  EXPECT_EQ(measure(rewritten_ + "/lz4"), kHasLz4 ? measures : "");
  EXPECT_EQ(log.lines("compressed with 'lz4'"), kHasLz4 ? 0 : 1) << log.text();
}

}  // namespace
}  // namespace tandem
