// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/over_dds.hpp"

#include "bringup/drive/drive_monitor.hpp"
#include "bringup/drive/drive_world.hpp"

namespace tandem {

DriveLog drive_over_dds(const Scenario& scenario, const DriveOptions& options,
                        const std::function<void(const Progress&)>& progress) {
  const Scenario drive = with_options(scenario, options);
  const System system = system_of(drive, options);
  rt::Node node{"scenario"};
  DriveMonitor monitor{node, DriveObserver{drive, system, drive_world(drive, system)}, progress};
  RunningSystem running{system};
  node.spin();
  running.stop();
  running.wait();
  return monitor.finish(drive.name);
}

}  // namespace tandem
