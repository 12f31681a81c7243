// SPDX-License-Identifier: Apache-2.0
// Tests properties of the parameters of all components together.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <variant>

#include "bringup/scenario/scenario.hpp"
#include "bringup/system/parameter_names.hpp"
#include "bringup/system/system.hpp"
#include "support/paths.hpp"
#include "tandem/local_planner/local_planner_node.hpp"
#include "tandem/obstacle_extractor/obstacle_extractor_node.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/safety_filter/safety_filter_node.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

class RobotFile : public ::testing::Test {
 protected:
  ~RobotFile() override { fs::remove(path_); }

  void write(const std::string& lines, const std::string& node = "/**") const {
    std::ofstream{path_} << node + ":\n  ros__parameters:\n" + lines;
  }

  // Throws if the component refuses the file.
  void check(const std::string& component) const {
    rt::check_parameters(component, {.name = "component", .parameters = {.files = {path_}}});
  }

  // The parameters that a component reads from a file with these lines.
  template <class P>
  [[nodiscard]] P read(const std::string& lines) const {
    write(lines);
    P params;
    rt::ParameterStore store{"/component", {.files = {path_}}};
    params.visit(store);
    store.check_unknown();
    tandem::check(params);
    return params;
  }

  const std::string path_ = testing::TempDir() + "robot_" + std::to_string(getpid()) + ".yaml";
};

TEST(Components, HaveNoTwoParametersOfOneName) {
  for (const auto& component : rt::list_components()) {
    std::set<std::string> names{"use_sim_time"};
    for (const auto& field : rt::description_of(component).parameters)
      EXPECT_TRUE(names.insert(field.name).second) << component << ": " << field.name;
  }
}

// libtandem_test_component.so lies beside this program, where modules are looked for.
TEST(Components, OfThirdPartiesHaveTheirParameterNamesKnown) {
  EXPECT_TRUE(is_parameter("factor"));
  EXPECT_TRUE(is_parameter("weight_heading"));
  EXPECT_FALSE(is_parameter("factr"));
  EXPECT_EQ(nearest_parameter("factr"), "; did you mean `factor`?");
  EXPECT_EQ(nearest_parameter("nothing_like_any_of_them"), "");
}

TEST_F(RobotFile, WithTheOldTimeoutIsRefusedByEveryComponent) {
  for (const auto& component : rt::list_components()) {
    for (const std::string node : {"component", "/**"}) {
      write("    command_timeout: 0.6\n", node);
      try {
        check(component);
        ADD_FAILURE() << component << " takes it from " << node;
      } catch (const std::invalid_argument& error) {
        const std::string line = error.what();
        for (const char* name : {"base_timeout", "arbitrated_timeout", "in_force_timeout"})
          EXPECT_NE(line.find(name), std::string::npos) << component << ": " << line;
      }
    }
  }
}

TEST_F(RobotFile, MayDescribeABaseThatNeverStopsByItself) {
  write("    base_timeout: 0\n");
  for (const auto& component : rt::list_components()) EXPECT_NO_THROW(check(component));
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
  for (const SystemNode& node : system.nodes) {
    const auto component = rt::description_of(node.component);
    rt::ParameterStore store{"/" + node.options.name, node.options.parameters};
    for (const rt::Field& field : component.parameters) {
      store.load(field);
      if (const auto* value = std::get_if<double*>(&field.value); value && field.name == parameter)
        values[node.component] = **value;
    }
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
