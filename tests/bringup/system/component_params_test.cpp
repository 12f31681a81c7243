// SPDX-License-Identifier: Apache-2.0
// Tests properties of the parameters of all components together.
#include "bringup/system/component_params.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "bringup/scenario/scenario.hpp"
#include "bringup/system/system.hpp"
#include "support/paths.hpp"
#include "tandem/runtime/parameter_fields.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

class RobotFile : public ::testing::Test {
 protected:
  ~RobotFile() override { fs::remove(path_); }

  // The parameters that a component reads from a file with these lines for `node`.
  template <class P>
  [[nodiscard]] P read(const std::string& lines, P params = {}, const std::string& node = "/**") {
    std::ofstream{path_} << node + ":\n  ros__parameters:\n" + lines;
    rt::ParameterStore store{"/component", {.files = {path_}}};
    params.visit(store);
    store.check_unknown();
    check(params);
    return params;
  }

  const std::string path_ = testing::TempDir() + "robot_" + std::to_string(getpid()) + ".yaml";
};

TEST(Components, HaveNoTwoParametersOfOneName) {
  for_each_component([](const char* component, auto params) {
    std::set<std::string> names{"use_sim_time"};
    for (const auto& field : rt::fields_of(params))
      EXPECT_TRUE(names.insert(field.name).second) << component << ": " << field.name;
  });
}

TEST_F(RobotFile, WithTheOldTimeoutIsRefusedByEveryComponent) {
  for_each_component([&](const char* component, auto params) {
    for (const std::string node : {"component", "/**"}) {
      try {
        (void)read("    command_timeout: 0.6\n", params, node);
        ADD_FAILURE() << component << " takes it from " << node;
      } catch (const std::invalid_argument& error) {
        const std::string line = error.what();
        for (const char* name : {"base_timeout", "arbitrated_timeout", "in_force_timeout"})
          EXPECT_NE(line.find(name), std::string::npos) << component << ": " << line;
      }
    }
  });
}

TEST_F(RobotFile, MayDescribeABaseThatNeverStopsByItself) {
  for_each_component([&](const char*, auto params) {
    EXPECT_NO_THROW((void)read("    base_timeout: 0\n", params));
  });
  const auto filter =
      read<SafetyFilterNodeParams>("    base_timeout: 0\n    survive_silence: false\n");
  EXPECT_EQ(filter.robot.base_timeout, 0.0);
  EXPECT_NO_THROW((SafetyFilter{filter.filter, filter.robot}));
}

TEST_F(RobotFile, LeavesThePlannerAndTheFilterTheirOwnTimeouts) {
  const std::string base = "    base_timeout: 0.6\n";
  EXPECT_EQ(read<LocalPlannerNodeParams>(base).timeouts.in_force_timeout,
            LocalPlannerNodeParams{}.timeouts.in_force_timeout);
  EXPECT_EQ(read<SafetyFilterNodeParams>(base).filter.arbitrated_timeout,
            SafetyFilterParams{}.arbitrated_timeout);
}

double width_for_extractor(const ObstacleExtractorNodeParams& params) {
  return extractor_for_robot(params).width;
}

TEST_F(RobotFile, GivesTheExtractorTheWidthOfItsOutline) {
  using Params = ObstacleExtractorNodeParams;
  EXPECT_NEAR(width_for_extractor(Params{}), 0.58, 1e-12);
  EXPECT_NEAR(width_for_extractor(read<Params>("    width: 0.43\n")), 0.43, 1e-12);
  const auto by_outline =
      read<Params>("    footprint: [-0.4, -0.17, 0.4, -0.17, 0.4, 0.17, -0.4, 0.17]\n");
  EXPECT_NEAR(width_for_extractor(by_outline), 0.34, 1e-12);
  EXPECT_NEAR(extractor_for_robot(by_outline).smallest_gap, 0.34, 1e-12);  // it fits in there
  EXPECT_THROW((void)extractor_for_robot(read<Params>("    footprint: [0, 0, 1, 1, 2, 2, 3]\n")),
               std::invalid_argument);
}

// The parameter's value in each component of a system that has it.
std::map<std::string, double> values_of(const std::string& parameter, const System& system) {
  std::map<std::string, double> values;
  for_each_component([&](const char* component, auto params) {
    params = parameters_of<decltype(params)>(system, component);
    params.visit([&](const char* name, const auto& value, const auto&...) {
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
        if (name == parameter) values[component] = value;
    });
  });
  for (const auto& [component, value] : std::map{values}) {
    const auto runs = [&, &name = component](const SystemNode& n) { return n.component == name; };
    if (std::none_of(system.nodes.begin(), system.nodes.end(), runs)) values.erase(component);
  }
  return values;
}

// A planner may be given less information on purpose, as in forest_lag.yaml.
void expect_filter_to_know(const std::string& parameter, const System& system) {
  const auto values = values_of(parameter, system);
  ASSERT_TRUE(values.contains("safety_filter")) << system.path;
  if (values.contains("diff_drive_sim")) {
    EXPECT_EQ(values.at("safety_filter"), values.at("diff_drive_sim"))
        << system.path << ": " << parameter;
  }
}

TEST(ShippedFiles, LetTheFilterBelieveOfTheBaseWhatTheBaseDoes) {
  for (const char* parameter :
       {"base_timeout", "command_delay", "sensor_delay", "motor_lag", "a_brake", "alpha_brake"}) {
    for (const auto& file : test::yaml_files("bringup/systems"))
      expect_filter_to_know(parameter, load_system(file));
    for (const auto& file : test::yaml_files("bringup/scenarios"))
      expect_filter_to_know(parameter, system_of(load_scenario(file), {}));
  }
}

TEST(ShippedFiles, OfTheThesisTablesLetTheFilterLookAsFarAheadAsTheBaseDrives) {
  for (const char* table : {"table_3_1", "table_3_2"}) {
    const Scenario scenario =
        load_scenario(test::source_path("bringup/scenarios/" + std::string{table} + ".yaml"));
    const auto filter =
        parameters_of<SafetyFilterNodeParams>(system_of(scenario, {}), "safety_filter");
    EXPECT_EQ(filter.robot.base_timeout, 0.6) << table;
    EXPECT_EQ(filter.filter.arbitrated_timeout, 0.4) << table;
  }
}

}  // namespace
}  // namespace tandem
