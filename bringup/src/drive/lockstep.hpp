// SPDX-License-Identifier: Apache-2.0
// Runs a scenario with its nodes on a local bus, without DDS and on simulated time.
#pragma once

#include <functional>
#include <memory>

#include "bringup/drive/drive_log.hpp"
#include "tandem/runtime/local_bus.hpp"
#include "tandem/runtime/result_cache.hpp"

namespace tandem {

/// Constructs everything that a drive needs, in lockstep or over DDS. Throws std::invalid_argument
/// with one line naming the file if a parameter or the map is invalid or the start is in an
/// obstacle.
void check_drive(const Scenario& scenario, const DriveOptions& options);

/// Runs the nodes of a system on an rt::LocalBus. Deterministic: on one machine, the same scenario
/// and options give the same drive bit for bit, except for the measured times. Keeps the last few
/// worlds and what was computed of them, which speeds up repeated drives in one world without
/// changing their results.
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
  /// The same; `prepare` is called with the bus before the nodes are made, to disturb its links or
  /// to add nodes.
  using Prepare = std::function<void(const std::shared_ptr<rt::LocalBus>&)>;
  [[nodiscard]] DriveLog drive(const Scenario& scenario, const DriveOptions& options,
                               const std::function<void(const Progress&)>& progress,
                               const Prepare& prepare);

 private:
  std::shared_ptr<rt::ResultCache> cache_;
  std::unique_ptr<class DriveWorlds> worlds_;
};

/// Runs a single drive in lockstep; see Lockstep.
[[nodiscard]] DriveLog drive_in_lockstep(const Scenario& scenario, const DriveOptions& options,
                                         const std::function<void(const Progress&)>& progress = {});

}  // namespace tandem
