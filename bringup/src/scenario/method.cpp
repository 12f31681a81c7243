// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/method.hpp"

#include <algorithm>
#include <stdexcept>

#include "tandem/config/nearest_name.hpp"

namespace tandem {
namespace {

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const DriveMethod& method : all_methods()) all.push_back(method.name);
  return all;
}

}  // namespace

const std::vector<DriveMethod>& all_methods() {
  static const std::vector<std::string> by_hand{"driver", "teleop"};
  static const std::vector<std::string> planned{"driver", "teleop", "local_planner"};

  static const std::vector<DriveMethod> methods{
      {.name = "manual",
       .about = "the person; the safety filter only watches",
       .policy = "manual",
       .enforce = false,
       .components = by_hand},
      {.name = "safety_filter",
       .about = "the person; the filter enforces",
       .policy = "manual",
       .components = by_hand},
      {.name = "leader",
       .about = "the planner follows the person's leader (Devalla 2020, §3.1.4)",
       .policy = "shared",
       .components = planned,
       .planner_method = "leader"},
      {.name = "intention",
       .about = "the planner does what the stick asks for (Krijnen 2020, §2.3)",
       .policy = "shared",
       .components = planned,
       .planner_method = "intention"},
      {.name = "path",
       .about = "the planner follows the trail of the person's leader (Devalla 2020, §5.1)",
       .policy = "shared",
       .components = planned,
       .planner_method = "path"},
      {.name = "blend",
       .about = "a mixture of person and planner, by danger and disagreement",
       .policy = "blend",
       .components = planned,
       .planner_method = "intention"},
      {.name = "adaptive",
       .about = "a mixture in which the planner's share follows how well the person drives",
       .policy = "adaptive",
       .components = planned,
       .planner_method = "intention"},
      {.name = "dwa",
       .about = "Shared Dynamic Window Approach: the sampled arc without collision that is closest "
                "to the stick's command",
       .policy = "shared",
       .components = {"driver", "teleop", "shared_dwa"}},
      {.name = "hindsight",
       .about =
           "the planner does what is best over all places that the person may mean, weighted by "
           "their probability (Javdani et al. 2015)",
       .policy = "shared",
       .components = {"driver", "teleop", "hindsight", "local_planner"},
       .planner_method = "intention",
       .remappings = {{"local_planner", {{"cmd_vel_user", "cmd_vel_assisted"}}}},
       .goal = GoalForm::kPoses},
      {.name = "goal",
       .about = "the planner goes to a pose",
       .policy = "autonomous",
       .components = {"local_planner"},
       .planner_method = "goal",
       .goal = GoalForm::kPose},
  };
  return methods;
}

std::string method_names() {
  std::string all;
  for (const auto& name : names()) all += (all.empty() ? "" : ", ") + name;
  return all;
}

const DriveMethod& drive_method(const std::string& name) {
  for (const DriveMethod& method : all_methods())
    if (method.name == name) return method;
  const std::string meant = nearest_name(name, names());
  throw std::invalid_argument("method `" + name + "` is not one of " + method_names() +
                              (meant.empty() ? "" : "; did you mean `" + meant + "`?"));
}

bool runs(const DriveMethod& method, const std::string& component) {
  const auto& all = method.components;
  return std::find(all.begin(), all.end(), component) != all.end();
}

bool has_person(const DriveMethod& method) { return runs(method, "driver"); }

bool steers_leader(const DriveMethod& method) {
  return method.planner_method == "leader" || method.planner_method == "path";
}

std::vector<std::string> components_of(const DriveMethod& method, const std::string& map_source) {
  std::vector<std::string> all{"map_server", "diff_drive_sim"};
  if (map_source != "static") all.emplace_back("octomap_builder");
  all.emplace_back("obstacle_extractor");
  all.insert(all.end(), method.components.begin(), method.components.end());
  all.insert(all.end(), {"arbitration", "safety_filter"});
  return all;
}

std::set<std::string> components_of_all_methods() {
  std::set<std::string> all;
  for (const DriveMethod& method : all_methods())
    for (const auto& name : components_of(method, "live")) all.insert(name);
  return all;
}

}  // namespace tandem
