// SPDX-License-Identifier: Apache-2.0
// In: a study file. Out: all its drives: scenarios × methods × drivers × seeds.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bringup/drive/lockstep.hpp"
#include "bringup/scenario/scenario.hpp"

namespace tandem {

/// One scenario by one method and one driver, for many seeds.
struct StudyCell {
  Scenario scenario;     ///< with everything that the study changes in it
  DriveOptions options;  ///< but for the seed
  std::string method;    ///< as results name it; the scenario's method may go by another name
  std::string driver;    ///< likewise
};

struct StudyDrive {
  std::size_t cell = 0;
  unsigned seed = 1;
};

struct Study {
  std::string name, path;
  std::vector<StudyCell> cells;
  std::vector<StudyDrive> drives;
  /// Whatever decides the results: two studies are the same if these are equal.
  nlohmann::json description;
};

/// Reads a study file:
///
///   study: NAME
///   scenarios: [FILE or {file: FILE, name: N, map: M, duration: D}, …]   # relative to this file
///   robots: [FILE, …]                      # instead of the scenarios' own, each with each
///   methods: [METHOD or {name: N, method: M, enforce: false, parameters: {COMPONENT: {…}}}, …]
///   drivers: [DRIVER or {name: N, driver: D, and parameters of the component driver}, …]
///            # of driver `replay` also `recording: FOLDER` and, if need be, `recording_topic: T`
///   seeds: 20 or 1-20 or [3, 5, 8]
///   overrides: {COMPONENT: {…}}
///   parts: [{any of the six above}, …]     # what a part does not say is said above
///
/// `methods: all`, which is the default, means those the scenario lists; without `drivers` the
/// scenario's drives. With another robot than its own, a scenario's results are called
/// SCENARIO_ROBOT. Throws std::invalid_argument or std::runtime_error, one line that names file,
/// line and key, for whatever is not of this form, and if a drive is listed twice.
[[nodiscard]] Study load_study(const std::string& path);

/// What the drive is called: scenario, method, driver, seed.
[[nodiscard]] std::string name_of(const Study& study, const StudyDrive& drive);

/// Constructs one drive of each cell; throws what check_seed, check_robot and
/// check_drive throw.
void check_study(const Study& study);

/// Makes one drive: {"drive": its measures, "track": [[x, y], …] thinned}. Where the goal is a
/// place, the same person drives by hand and without obstacles first, for the time ratio.
[[nodiscard]] nlohmann::json make_drive(const Study& study, const StudyDrive& drive,
                                        Lockstep& lockstep);

}  // namespace tandem
