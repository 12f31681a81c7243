// SPDX-License-Identifier: Apache-2.0
// Reads a study file and runs its drives: scenarios × methods × drivers × seeds.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bringup/drive/lockstep.hpp"
#include "bringup/scenario/scenario.hpp"

namespace tandem {

/// One scenario with one method and one driver, for many seeds.
struct StudyCell {
  Scenario scenario;     ///< with the changes that the study makes to it
  DriveOptions options;  ///< all but the seed
  std::string method;    ///< name in the results; may differ from the scenario's method
  std::string driver;    ///< name in the results
};

struct StudyDrive {
  std::size_t cell = 0;
  unsigned seed = 1;
};

struct Study {
  std::string name, path;
  std::vector<StudyCell> cells;
  std::vector<StudyDrive> drives;
  /// Everything that determines the results: two studies are the same if these are equal.
  nlohmann::json description;
};

/// Reads a study file:
///
///   study: NAME
///   about: TEXT                            # optional
///   scenarios: [FILE or {file: FILE, name: N, map: M, duration: D}, …]   # relative to this file
///   robots: [FILE, …]                      # each scenario with each of these robots
///   methods: [METHOD or {name: N, method: M, enforce: false, parameters: {COMPONENT: {…}}}, …]
///   drivers: [DRIVER or {name: N, driver: D, and parameters of the component driver}, …]
///            # driver `replay` also takes `recording: FOLDER` and `recording_topic: T` (optional)
///   seeds: 20 or 1-20 or [3, 5, 8]
///   overrides: {COMPONENT: {…}}
///   parts: [{any of scenarios … overrides}, …]   # missing keys are taken from above
///
/// `methods: all`, the default, stands for the methods that the scenario lists. Without `drivers`,
/// the scenario's driver is used. With another robot than its own, a scenario's results are named
/// SCENARIO_ROBOT. Throws std::invalid_argument or std::runtime_error, with one line naming file,
/// line and key, if the file does not have this form or lists a drive twice.
[[nodiscard]] Study load_study(const std::string& path);

/// Name of a drive: scenario/method/driver/seed.
[[nodiscard]] std::string name_of(const Study& study, const StudyDrive& drive);

/// Constructs one drive of each cell. Throws what check_seed, check_robot and check_drive throw.
void check_study(const Study& study);

/// Runs one drive: {"drive": its measures, "track": [[x, y], …] thinned, "contacts": [[x, y], …],
/// "cost_s": CPU time of this process}, in M [m]. If the goal is a place and a person drives, the
/// same person also drives by hand without obstacles, for the time ratio.
[[nodiscard]] nlohmann::json make_drive(const Study& study, const StudyDrive& drive,
                                        Lockstep& lockstep);

}  // namespace tandem
