// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/lockstep.hpp"

#include <sys/resource.h>

#include <stdexcept>
#include <string>

#include "bringup/drive/drive_monitor.hpp"
#include "bringup/drive/drive_world.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

constexpr std::size_t kMaxResults = 64;  // maps and their shapes

// CPU time of this process so far, user and system [s].
double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

rt::NodeOptions on_bus(rt::NodeOptions options, const std::shared_ptr<rt::LocalBus>& bus) {
  options.bus = bus;
  options.serves_tools = false;
  options.log_level = rt::LogLevel::kError;
  return options;
}

System on_bus(System system, const std::shared_ptr<rt::LocalBus>& bus) {
  for (SystemNode& node : system.nodes) node.options = on_bus(std::move(node.options), bus);
  return system;
}

PartTimes part_times(const rt::LocalBus& bus) {
  const auto of = [&](const char* node) { return bus.busy(std::string{"/"} + node); };
  PartTimes times;
  times.simulator = of("map_server") + of("diff_drive_sim");
  times.extractor = of("obstacle_extractor") + of("octomap_builder");
  times.planner = of("local_planner") + of("shared_dwa") + of("hindsight");
  times.filter = of("arbitration") + of("safety_filter");
  times.person = of("driver") + of("teleop");
  times.measures = of("scenario");
  return times;
}

}  // namespace

void check_drive(const Scenario& scenario, const DriveOptions& options) {
  Lockstep{}.check(scenario, options);
}

void Lockstep::check(const Scenario& scenario, const DriveOptions& options) {
  const Scenario drive = with_options(scenario, options);
  try {
    const System system = system_of(drive, options);
    check_places(drive, system, *worlds_->of(drive, system).map);
    const auto bus = std::make_shared<rt::LocalBus>(drive.seed, cache_);
    const RunningSystem constructed{on_bus(system, bus)};
  } catch (const std::exception& error) {
    const std::string what = error.what();
    if (what.starts_with(drive.path)) throw;
    throw std::invalid_argument(drive.path + ": " + what);
  }
}

Lockstep::Lockstep()
    : cache_{std::make_shared<rt::ResultCache>(kMaxResults)},
      worlds_{std::make_unique<DriveWorlds>(cache_)} {}
Lockstep::~Lockstep() = default;

DriveLog drive_in_lockstep(const Scenario& scenario, const DriveOptions& options,
                           const std::function<void(const Progress&)>& progress) {
  return Lockstep{}.drive(scenario, options, progress);
}

DriveLog Lockstep::drive(const Scenario& scenario, const DriveOptions& options,
                         const std::function<void(const Progress&)>& progress) {
  return this->drive(scenario, options, progress, {});
}

DriveLog Lockstep::drive(const Scenario& scenario, const DriveOptions& options,
                         const std::function<void(const Progress&)>& progress,
                         const Prepare& prepare) {
  const double start = rt::steady_seconds(), cpu_start = cpu_seconds();
  const Scenario drive = with_options(scenario, options);
  const auto bus = std::make_shared<rt::LocalBus>(drive.seed, cache_);
  if (prepare) prepare(bus);
  const System system = system_of(drive, options);
  rt::Node node{on_bus({.name = "scenario"}, bus)};
  DriveMonitor monitor{node, DriveObserver{drive, system, worlds_->of(drive, system)}, progress};
  const RunningSystem running{on_bus(system, bus)};
  const double ready = rt::steady_seconds();
  node.spin();
  DriveLog log = monitor.finish(drive.name);
  log.result.wall_s = rt::steady_seconds() - ready;
  log.result.part_s = part_times(*bus);
  log.result.part_s.setup = ready - start;
  log.result.cpu_s = cpu_seconds() - cpu_start;
  log.result.lockstep = true;
  return log;
}

}  // namespace tandem
