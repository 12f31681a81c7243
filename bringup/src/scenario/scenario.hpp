// SPDX-License-Identifier: Apache-2.0
// Loads scenario files and builds the system of components that runs the drive they describe.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bringup/system/system.hpp"
#include "tandem/diff_drive_sim/people.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {

class YamlReader;

/// Conditions that must hold after a drive with any method except those in `except`.
struct Expectation {
  bool reached = true;
  int max_collisions = 0;
  double max_fallback_share = 1.0;        ///< of the planner's cycles
  double max_final_position_error = 1e9;  ///< [m]
  std::vector<std::string> except;
};

/// A drive through a map: map, robot, goal, driver, and the conditions that must hold.
struct Scenario {
  std::string name, path;
  std::string map;                    ///< map file, or a map generator (seeded_world.hpp)
  std::string robot;                  ///< parameter file
  std::string fixtures;               ///< file of virtual fixtures; empty: none
  std::string map_source = "static";  ///< of extractor and filter; else an octomap_builder runs too
  Pose2 start;
  Goal goal;
  std::string goal_edge;  ///< front, rear, left or right: the edge that must reach the pose
  std::optional<RegionGoal> after;   ///< to be visited by that edge, or base_link, first
  Eigen::Vector2d p_BA{0.0, 0.0};    ///< that edge's point on the robot [m], set by with_options()
  std::vector<Pose2> goals;          ///< if there are several poses: the seed selects one
  std::string method;                ///< see method.hpp; the command line may name another
  std::vector<std::string> methods;  ///< methods the scenario is meant for
  std::string driver = "navigator";  ///< and its modifiers, as driver/driver.hpp names them
  std::string recording;             ///< played by the driver `replay`; otherwise empty
  std::string recording_topic;       ///< its joystick topic; empty: see recorded_stick()
  double duration = 120.0;           ///< [s] simulated time limit
  unsigned seed = 1;
  std::map<std::string, rt::ParameterValue> slice;  ///< of the map: z_min, z_max, floor
  std::map<std::string, std::map<std::string, rt::ParameterValue>> parameters;  ///< per component
  std::vector<Walker> people;        ///< walkers; filter and planner then use obstacle tracks
  std::vector<Crossings> crossings;  ///< walkers generated from the seed
  Expectation expect;
};

/// All walkers in the scenario's drive.
[[nodiscard]] std::vector<Walker> people_in(const Scenario& scenario);

/// Command-line options that override the scenario.
struct DriveOptions {
  std::string method{};  ///< empty: the scenario's
  unsigned seed = 0;     ///< 0: the scenario's
  std::string map{};     ///< empty: the scenario's
  bool enforce = true;   ///< false: the filter only monitors, to test the planner alone
  bool lockstep = false;
  double speed = 1.0;             ///< simulated per real time, over DDS
  std::string driver{};           ///< empty: the scenario's
  std::string recording{};        ///< empty: the scenario's
  std::string recording_topic{};  ///< likewise
};

/// The driver's name as in the results; `none` without a driver.
[[nodiscard]] std::string driver_of(const Scenario& scenario);

/// Parameters per component, as under `parameters:` of a scenario file. Throws
/// std::invalid_argument naming the file, the line and the unknown component, the unknown parameter
/// or the value that is out of bounds.
[[nodiscard]] std::map<std::string, std::map<std::string, rt::ParameterValue>> component_parameters(
    YamlReader map);

/// Throws std::invalid_argument naming file, line and key if the file is not a valid scenario.
[[nodiscard]] Scenario load_scenario(const std::string& path);

/// Throws std::invalid_argument that names the file if the method or the driver is unknown or a
/// setting it needs is missing.
void check_scenario(const Scenario& scenario);

/// Throws std::invalid_argument that names file, line and key if the robot's file sets, under
/// `/**`, a parameter that no component of any method has.
void check_robot(const Scenario& scenario);

/// The scenario with the options applied, in the world of its seed if the map is a generator.
/// Throws std::invalid_argument for an unknown method or driver, and whatever in_its_world()
/// throws.
[[nodiscard]] Scenario with_options(Scenario scenario, const DriveOptions& options);

/// The components of a drive with all their parameters. In lockstep the solver has no wall-clock
/// budget, so that the same seed gives the same drive.
[[nodiscard]] System system_of(const Scenario& scenario, const DriveOptions& options);

/// One line for each expected condition that did not hold.
[[nodiscard]] std::vector<std::string> failures(const Scenario& scenario,
                                                const DriveResult& result);

/// A component's parameters as its node reads them.
template <class P>
[[nodiscard]] P parameters_of(const System& system, const std::string& component) {
  P params;
  for (const SystemNode& node : system.nodes) {
    if (node.component != component) continue;
    rt::ParameterStore store{"/" + node.options.name, node.options.parameters};
    params.visit(store);
    bool use_sim_time = false;
    store("use_sim_time", use_sim_time, "");
    store.check_unknown();
    check(params);
  }
  return params;
}

}  // namespace tandem
