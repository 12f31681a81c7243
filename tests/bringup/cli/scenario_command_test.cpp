// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/scenario_command.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "bringup/scenario/method.hpp"

namespace tandem {
namespace {

TEST(ScenarioCommand, ListsEveryMethodInItsHelp) {
  CLI::App program{"tandem"};
  int status = 0;
  add_scenario_command(program, status);
  const std::string help = program.get_subcommand("scenario")->help();
  for (const DriveMethod& method : all_methods()) {
    EXPECT_NE(help.find("\n  " + method.name + " "), std::string::npos) << method.name;
    EXPECT_NE(help.find(method.about), std::string::npos) << method.name;
  }
}

}  // namespace
}  // namespace tandem
