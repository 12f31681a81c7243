// SPDX-License-Identifier: Apache-2.0
// The table of methods, by which manual driving, planners and mixtures of both are compared. Adding
// a method is adding a row in method.cpp.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

namespace tandem {

/// The goal that a scenario must have for a method.
enum class GoalForm { kAny, kPose, kPoses };

/// One method: what runs beside the components of every drive, and how it is set.
struct DriveMethod {
  std::string name;
  std::string about;                    ///< what drives the robot, in one line
  std::string policy;                   ///< of arbitration
  bool enforce = true;                  ///< false: the safety filter only watches
  std::vector<std::string> components;  ///< that run beside those of every drive
  std::string planner_method{};         ///< of local_planner; empty if it does not run
  std::map<std::string, std::map<std::string, std::string>> remappings{};  ///< per component
  GoalForm goal = GoalForm::kAny;
};

/// All methods, in the order in which documents and help list them.
[[nodiscard]] const std::vector<DriveMethod>& all_methods();

/// All names, as "manual, safety_filter, …".
[[nodiscard]] std::string method_names();

/// The method of that name. Throws std::invalid_argument that lists the names, and suggests the
/// nearest one, if there is none.
[[nodiscard]] const DriveMethod& drive_method(const std::string& name);

/// Whether the method runs the component beside those of every drive.
[[nodiscard]] bool runs(const DriveMethod& method, const std::string& component);

/// Whether a person drives, simulated by the component driver.
[[nodiscard]] bool has_person(const DriveMethod& method);

/// Whether the person steers the leader rather than the robot.
[[nodiscard]] bool steers_leader(const DriveMethod& method);

/// The components of a drive with this method, in the order of the data flow; see
/// Scenario::map_source.
[[nodiscard]] std::vector<std::string> components_of(const DriveMethod& method,
                                                     const std::string& map_source);

/// Every component that a drive with any method may run.
[[nodiscard]] std::set<std::string> components_of_all_methods();

}  // namespace tandem
