// SPDX-License-Identifier: Apache-2.0
// Tests hostile text from outside: YAML that would exhaust memory or the stack, wherever YAML is
// read, and control characters.
#include "tandem/config/printable.hpp"
#include "tandem/config/yaml_document.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>

#include "bringup/bag/bag_qos.hpp"
#include "bringup/scenario/scenario.hpp"
#include "bringup/study/study.hpp"
#include "bringup/system/system.hpp"
#include "support/paths.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/virtual_fixtures.hpp"
#include "tandem/runtime/parameter_fields.hpp"
#include "tandem/runtime/parameter_files.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

// Nine nested lists of nine aliases each: 9⁹ values.
std::string alias_bomb() {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i) {
    const std::string name = "a" + std::to_string(i), before = "*a" + std::to_string(i - 1);
    text += name + ": &" + name + " [" + repeated(before + ", ", 8) + before + "]\n";
  }
  return text;
}

const std::vector<std::string>& hostile_texts() {
  static const std::vector<std::string> texts{",",
                                              ", \n",
                                              "a: 1\n, b",
                                              "]",
                                              "}",
                                              "- a\n]\n",
                                              alias_bomb(),
                                              "&a [*a]",
                                              repeated("[", 200'000),
                                              repeated("- ", 200'000),
                                              repeated("a: {", 200'000)};
  return texts;
}

TEST(YamlDocument, RefusesTextThatWouldTakeAllMemoryOrTheStack) {
  for (const auto& text : hostile_texts()) {
    EXPECT_THROW((void)parse_document(text), YAML::Exception) << text.substr(0, 40);
  }
  EXPECT_THROW((void)parse_document(repeated("- 1\n", 1'000'001)), YAML::Exception);
  EXPECT_THROW((void)parse_document(std::string((16U << 20U) + 1, ' ')), YAML::Exception);
}

TEST(YamlDocument, ReadsLargeValidText) {
  EXPECT_EQ(parse_document(repeated("- 1\n", 100'000)).size(), 100'000U);
  EXPECT_EQ(parse_document(repeated("[", 60) + repeated("]", 60)).size(), 1U);
  EXPECT_EQ(parse_document("a: &a 1\nb: *a\n")["b"].as<int>(), 1);
  EXPECT_TRUE(parse_document("").IsNull());
}

TEST(YamlDocument, NamesFileAndLineInOneLine) {
  const std::string file = fs::temp_directory_path() / ("tandem_yaml_" + std::to_string(getpid()));
  std::ofstream{file} << "a: 1\nb: [2\n";
  try {
    (void)load_document(file);
    FAIL() << "was read";
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string{error.what()}.find(file + ":"), 0U) << error.what();
    EXPECT_EQ(std::string{error.what()}.find('\n'), std::string::npos) << error.what();
  }
  fs::remove(file);
}

TEST(YamlDocument, NamesAPathThatIsNotAFile) {
  for (const auto& [file, what] :
       {std::pair{"/nowhere.yaml", "no such file"}, std::pair{"/tmp", "is a folder"},
        std::pair{"/dev/zero", "larger than 16 MiB"}}) {
    try {
      (void)load_document(file);
      FAIL() << file << " was read";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string{error.what()}.find(what), std::string::npos) << error.what();
    }
  }
}

TEST(Printable, KeepsALineALine) {
  EXPECT_EQ(printable("a\nb\x1b[31m\x7f"), "a?b?[31m?");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "?31m")
      << "C1's CSI";
  EXPECT_EQ(printable("0,8 m – 2 µs, größer"), "0,8 m – 2 µs, größer");
  EXPECT_EQ(printable(""), "");
}

struct Entrance {
  const char* name;
  std::function<void(const std::string& file)> read;
};

void PrintTo(const Entrance& entrance, std::ostream* out) { *out << entrance.name; }

// Where a file is no file of the kind that is expected either, the error is what counts: it ends.
class YamlEntrance : public ::testing::TestWithParam<Entrance> {
 protected:
  ~YamlEntrance() override { fs::remove(file_); }
  std::string file_ =
      fs::temp_directory_path() / ("tandem_hostile_" + std::to_string(getpid()) + ".yaml");
};

TEST_P(YamlEntrance, EndsWithAnErrorThatNamesTheFile) {
  for (const auto& text : hostile_texts()) {
    std::ofstream{file_, std::ios::trunc} << text;
    try {
      GetParam().read(file_);
      FAIL() << text.substr(0, 40) << " was read";
    } catch (const std::exception& error) {
      EXPECT_NE(std::string{error.what()}.find(file_), std::string::npos) << error.what();
    }
  }
}

TEST_P(YamlEntrance, EndsWithAnErrorForFilesThatOnceTookAllMemory) {
  const fs::path folder = test::shared_path("hostile");
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  for (const auto& entry : fs::directory_iterator{folder}) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_ANY_THROW(GetParam().read(entry.path())) << entry.path();
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfThe, YamlEntrance,
    ::testing::Values(
        Entrance{"Map", [](const auto& file) { (void)load_map(file, 1.0); }},
        Entrance{"Fixtures", [](const auto& file) { (void)load_virtual_fixtures(file); }},
        Entrance{"Scenario", [](const auto& file) { (void)load_scenario(file); }},
        Entrance{"Study", [](const auto& file) { (void)load_study(file); }},
        Entrance{"System", [](const auto& file) { (void)load_system(file); }},
        Entrance{"Parameters",
                 [](const auto& file) { (void)rt::read_parameter_file(file, "/local_planner"); }}),
    [](const auto& tested) { return std::string{tested.param.name}; });

TEST(YamlText, AParameterThatIsNotYamlIsNotSet) {
  for (const auto& text : hostile_texts()) {
    EXPECT_EQ(rt::value_from_yaml(text).type(), 0) << text.substr(0, 40);
  }
  EXPECT_EQ(rt::value_from_yaml(", a").type(), 0);
}

TEST(YamlText, AQosProfileThatIsNotYamlIsIgnored) {
  const rt::QoS unsaid = recorded_qos("/odom", "");
  for (const auto& text : hostile_texts()) {
    const rt::QoS qos = recorded_qos("/odom", text);
    EXPECT_EQ(qos.reliability, unsaid.reliability) << text.substr(0, 40);
    EXPECT_EQ(qos.depth, unsaid.depth) << text.substr(0, 40);
  }
}

}  // namespace
}  // namespace tandem
