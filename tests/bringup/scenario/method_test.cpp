// SPDX-License-Identifier: Apache-2.0
// Tests that every row of the table of methods is complete, and that documents agree with it.
#include "bringup/scenario/method.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "bringup/scenario/scenario.hpp"
#include "bringup/system/parameter_names.hpp"
#include "support/paths.hpp"
#include "tandem/arbitration/arbiter.hpp"
#include "tandem/driver/driver_node.hpp"
#include "tandem/local_planner/local_planner_node.hpp"
#include "tandem/safety_filter/safety_filter_node.hpp"

namespace tandem {
namespace {

long count_in(const std::vector<std::string>& all, const char* name) {
  return std::count(all.begin(), all.end(), name);
}

// The part of a document under the heading "## The methods".
std::string methods_of(const std::string& document) {
  std::ifstream file{test::source_path(document)};
  const std::string text{std::istreambuf_iterator<char>{file}, {}};
  const auto begin = text.find("\n## The methods\n");
  EXPECT_NE(begin, std::string::npos) << document;
  return begin == std::string::npos ? ""
                                    : text.substr(begin, text.find("\n## ", begin + 1) - begin);
}

// A scenario whose goal has the form that the method needs.
Scenario scenario_for(const DriveMethod& method) {
  const bool has_places = method.goal == GoalForm::kPoses;
  Scenario scenario = load_scenario(test::source_path(
      has_places ? "bringup/scenarios/ward_goals.yaml" : "bringup/scenarios/forest_task2.yaml"));
  if (method.goal == GoalForm::kPose) scenario.goal = PoseGoal{.X_MG = {4.0, 2.5, 0.0}};
  scenario.method = method.name;
  return scenario;
}

std::string complaint_about(const std::string& name) {
  try {
    (void)drive_method(name);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

class EveryMethod : public testing::TestWithParam<DriveMethod> {
 protected:
  const DriveMethod& method_ = GetParam();
};

TEST_P(EveryMethod, HasANameATextAndASoundPolicy) {
  EXPECT_FALSE(method_.name.empty());
  EXPECT_EQ(method_.name.find_first_of(" /,"), std::string::npos) << "is part of file names";
  EXPECT_FALSE(method_.about.empty());
  EXPECT_EQ(method_.about.find('\n'), std::string::npos);
  ArbiterParams arbiter;
  arbiter.policy = method_.policy;
  EXPECT_NO_THROW(check(arbiter));
}

TEST_P(EveryMethod, GivesThePlannerAMethodExactlyIfItRuns) {
  EXPECT_EQ(method_.planner_method.empty(), !runs(method_, "local_planner"));
  LivePlannerParams planner;
  if (!method_.planner_method.empty()) planner.method = method_.planner_method;
  EXPECT_NO_THROW(check(planner));
}

TEST_P(EveryMethod, NamesComponentsThatExistEachOnce) {
  const std::set<std::string> each{method_.components.begin(), method_.components.end()};
  EXPECT_EQ(each.size(), method_.components.size());
  for (const auto& component : components_of(method_, "static"))
    EXPECT_NO_THROW((void)rt::description_of(component)) << component;
  for (const auto& [component, topics] : method_.remappings)
    EXPECT_TRUE(each.contains(component)) << component << " does not run";
}

TEST_P(EveryMethod, DrivesASystemOfItsComponentsWithSoundParameters) {
  const Scenario scenario = with_options(scenario_for(method_), {});
  const System system = system_of(scenario, {});
  std::vector<std::string> components;
  for (const SystemNode& node : system.nodes) {
    components.push_back(node.component);
    const auto remapped = method_.remappings.find(node.component);
    EXPECT_EQ(node.options.remappings, remapped == method_.remappings.end()
                                           ? decltype(node.options.remappings){}
                                           : remapped->second);
    EXPECT_NO_THROW(rt::check_parameters(node.component, node.options)) << node.component;
  }
  EXPECT_EQ(components, components_of(method_, scenario.map_source));
  const auto filter = parameters_of<SafetyFilterNodeParams>(system, "safety_filter");
  EXPECT_EQ(filter.filter.enforce, method_.enforce);
  EXPECT_EQ(parameters_of<ArbiterParams>(system, "arbitration").policy, method_.policy);
}

TEST_P(EveryMethod, StandsInTheReadmeAndInTheTextOnScenarios) {
  EXPECT_NE(methods_of("README.md").find("\n| `" + method_.name + "` | " + method_.about + " |\n"),
            std::string::npos);
  EXPECT_NE(methods_of("bringup/scenarios/README.md").find("`" + method_.name + "`"),
            std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryMethod, testing::ValuesIn(all_methods()),
                         [](const auto& test) { return test.param.name; });

TEST(Methods, HaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const DriveMethod& method : all_methods())
    EXPECT_TRUE(names.insert(method.name).second) << method.name;
}

TEST(Methods, AreAllThatTheReadmeLists) {
  const std::string section = methods_of("README.md");
  std::size_t rows = 0;
  for (auto at = section.find("\n| `"); at != std::string::npos; at = section.find("\n| `", at + 1))
    ++rows;
  EXPECT_EQ(rows, all_methods().size());
}

TEST(Methods, HaveAPersonAtTheStickUnlessThePlannerDrivesAlone) {
  for (const DriveMethod& method : all_methods()) {
    EXPECT_EQ(has_person(method), method.policy != "autonomous") << method.name;
    EXPECT_EQ(has_person(method), runs(method, "teleop")) << method.name;
  }
}

// The simulated person must steer what the planner follows.
TEST(Methods, WhosePlannerFollowsTheLeaderHaveAPersonWhoSteersIt) {
  for (const DriveMethod& method : all_methods()) {
    if (!has_person(method)) continue;
    const System system = system_of(with_options(scenario_for(method), {}), {});
    const bool follows = method.planner_method == "leader" || method.planner_method == "path";
    EXPECT_EQ(parameters_of<DriverNodeParams>(system, "driver").steers_leader, follows)
        << method.name;
  }
}

TEST(Methods, OfAScenarioRunTheMapBuilderIfItHasNoFinishedMap) {
  const DriveMethod& manual = drive_method("manual");
  EXPECT_EQ(count_in(components_of(manual, "static"), "octomap_builder"), 0);
  EXPECT_EQ(count_in(components_of(manual, "local"), "octomap_builder"), 1);
  EXPECT_TRUE(components_of_all_methods().contains("octomap_builder"));
}

TEST(UnknownMethod, IsAnsweredWithTheListAndTheNearestName) {
  const std::string line = complaint_about("leadr");
  EXPECT_TRUE(line.starts_with("method `leadr` is not one of manual, safety_filter, ")) << line;
  EXPECT_TRUE(line.ends_with("; did you mean `leader`?")) << line;
  for (const DriveMethod& method : all_methods())
    EXPECT_NE(line.find(method.name), std::string::npos) << line;
}

TEST(UnknownMethod, FarFromEveryNameGetsNoSuggestion) {
  EXPECT_EQ(complaint_about("magic").find("did you mean"), std::string::npos);
}

// The system file and the table describe the same assistance.
TEST(Methods, HindsightIsRemappedAsInItsSystemFile) {
  const System system = load_system(test::source_path("bringup/systems/hindsight.yaml"));
  const auto planner =
      std::find_if(system.nodes.begin(), system.nodes.end(),
                   [](const SystemNode& node) { return node.component == "local_planner"; });
  ASSERT_NE(planner, system.nodes.end());
  EXPECT_EQ(planner->options.remappings, drive_method("hindsight").remappings.at("local_planner"));
}

}  // namespace
}  // namespace tandem
