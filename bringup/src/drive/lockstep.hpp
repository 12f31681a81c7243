// SPDX-License-Identifier: Apache-2.0
// In: a scenario. Out: its drive, by the same cores as over DDS, with no DDS and no clock.
#pragma once

#include <functional>
#include <memory>

#include "bringup/drive/drive_log.hpp"

namespace tandem {

/// Constructs everything that a drive needs, in lockstep or over DDS, and throws
/// std::invalid_argument, one line that names the file, if anything is wrong: a parameter, the map,
/// a start in an obstacle.
void check_drive(const Scenario& scenario, const DriveOptions& options);

/// Runs the components' cores in one loop on simulated time. Deterministic: the same scenario,
/// options and machine give the same drive, bit for bit (but for the measured times). Keeps the
/// last few worlds with the shapes that were fitted in them, so that many drives in one world cost
/// less; that changes no drive.
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

/// One such drive.
[[nodiscard]] DriveLog drive_in_lockstep(const Scenario& scenario, const DriveOptions& options,
                                         const std::function<void(const Progress&)>& progress = {});

}  // namespace tandem
