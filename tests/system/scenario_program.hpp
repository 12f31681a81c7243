// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"

namespace tandem::test {

/// Runs `tandem scenario` as a user does.
class ScenarioProgram : public ::testing::Test {
 protected:
  ScenarioProgram() { std::filesystem::create_directories(folder_); }
  ~ScenarioProgram() override { std::filesystem::remove_all(folder_); }

  // Runs `tandem scenario` and returns its exit status.
  int run(const std::string& scenario, std::vector<std::string> options, double timeout = 150.0) {
    std::vector<std::string> arguments{"scenario",
                                       source_path("bringup/scenarios/" + scenario + ".yaml"),
                                       "--json", json_file().string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    ChildProcess program{"../tandem", arguments};
    return program.wait(timeout).value_or(-1);
  }
  [[nodiscard]] nlohmann::json json() const {
    std::ifstream in{json_file()};
    return nlohmann::json::parse(in);
  }
  [[nodiscard]] std::filesystem::path json_file() const { return folder_ / "result.json"; }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("tandem_scenario_" + std::to_string(getpid()));
};

}  // namespace tandem::test
