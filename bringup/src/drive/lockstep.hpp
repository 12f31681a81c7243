// SPDX-License-Identifier: Apache-2.0
// Runs a scenario with the cores of the nodes in one loop, without DDS and on simulated time.
#pragma once

#include <functional>
#include <memory>

#include "bringup/drive/drive_log.hpp"

namespace tandem {

/// Constructs everything that a drive needs, in lockstep or over DDS. Throws std::invalid_argument
/// with one line naming the file if a parameter or the map is invalid or the start is in an
/// obstacle.
void check_drive(const Scenario& scenario, const DriveOptions& options);

/// Runs the components' cores in one loop on simulated time. Deterministic: on one machine, the
/// same scenario and options give the same drive bit for bit, except for the measured times. Caches
/// the last few worlds and the shapes fitted in them, which speeds up repeated drives in one world
/// without changing their results.
class Lockstep {
 public:
  Lockstep();
  ~Lockstep();
  Lockstep(const Lockstep&) = delete;
  Lockstep& operator=(const Lockstep&) = delete;

  /// See check_drive.
  void check(const Scenario& scenario, const DriveOptions& options);

  /// Throws what the components' constructors throw.
  [[nodiscard]] DriveLog drive(const Scenario& scenario, const DriveOptions& options,
                               const std::function<void(const Progress&)>& progress = {});

 private:
  std::unique_ptr<class Worlds> worlds_;
};

/// Runs a single drive in lockstep; see Lockstep.
[[nodiscard]] DriveLog drive_in_lockstep(const Scenario& scenario, const DriveOptions& options,
                                         const std::function<void(const Progress&)>& progress = {});

}  // namespace tandem
