// SPDX-License-Identifier: Apache-2.0
#include "bringup/lockstep.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "arbitration/arbiter.hpp"
#include "diff_drive_sim/diff_drive_sim_node.hpp"
#include "driver/driver_node.hpp"
#include "local_planner/local_planner_node.hpp"
#include "map/octomap_file.hpp"
#include "obstacle_extractor/obstacle_extractor_node.hpp"
#include "safety_filter/safety_filter_node.hpp"
#include "teleop/teleop_node.hpp"

namespace tandem {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool has(const System& system, const std::string& component) {
  for (const auto& node : system.nodes)
    if (node.component == component) return true;
  return false;
}

// A beat of a fixed period on simulated time, counted in ticks so that nothing drifts.
class TickTimer {
 public:
  TickTimer(double period, double tick) : ticks_{std::max(1L, std::lround(period / tick))} {}
  [[nodiscard]] bool due(long tick) const { return tick % ticks_ == 0; }

 private:
  long ticks_;
};

// What really stands there; the components add what they were told to keep away from.
std::shared_ptr<const StaticMap> world_of(const DiffDriveSimNodeParams& sim) {
  return std::make_shared<const StaticMap>(slice(*load_octomap(sim.map), sim.slice),
                                           sim.unknown_is_obstacle);
}

std::shared_ptr<const StaticMap> map_of(const DiffDriveSimNodeParams& sim,
                                        const MapInputParams& params) {
  return static_map(*load_octomap(sim.map), params, fixtures_of(params));
}

// The components' cores, wired as the nodes are wired by topics.
class Loop {
 public:
  Loop(const Scenario& scenario, const System& system)
      : scenario_{scenario},
        sim_params_{parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim")},
        planner_params_{parameters_of<LocalPlannerNodeParams>(system, "local_planner")},
        driver_params_{parameters_of<DriverNodeParams>(system, "driver")},
        filter_params_{parameters_of<SafetyFilterNodeParams>(system, "safety_filter")},
        extractor_params_{parameters_of<ObstacleExtractorNodeParams>(system, "obstacle_extractor")},
        map_{world_of(sim_params_)},
        sim_{sim_params_.sim, sim_params_.robot, map_, scenario.seed},
        localization_{filter_params_.input.localization},
        teleop_{parameters_of<TeleopNodeParams>(system, "teleop").teleop},
        extractor_{map_of(sim_params_, extractor_params_.map), extractor_params_.extractor},
        guidance_{guidance_of(planner_params_)},
        arbiter_{parameters_of<ArbiterParams>(system, "arbitration")},
        filter_{filter_params_.filter, filter_params_.robot},
        metrics_{scenario.goal, sim_params_.robot.v_max, sim_params_.robot.w_max} {
    if (has(system, "driver")) driver_.emplace(driver_params_.driver, scenario.seed);
    if (has(system, "local_planner")) nmpc_.emplace(planner_params_.nmpc, planner_params_.robot);
    sim_.reset(scenario.start, scenario.seed);
    filter_.on_map(map_of(sim_params_, filter_params_.map));
  }

  // Throws std::invalid_argument if the drive would begin in an obstacle, or there is none at all.
  void check_start() const {
    const auto& slice = sim_params_.slice;
    const auto& cells = map_->grid().cells;
    if (!sim_params_.unknown_is_obstacle &&
        std::find(cells.begin(), cells.end(), Cell::kOccupied) == cells.end())
      throw std::invalid_argument(fmt::format(
          "{} holds nothing from {} m to {} m above the floor at {} m; see z_min, z_max, floor",
          scenario_.map, slice.z_min, slice.z_max, slice.floor));
    const Pose2& X = scenario_.start;
    if (map_->clearance(sim_.footprint(), X, 1.0) <= 0.0)
      throw std::invalid_argument(fmt::format(
          "start: [{}, {}, {}] puts the robot's outline into an obstacle", X.x, X.y, X.theta));
  }

  DriveLog run(const std::function<void(const Progress&)>& progress) {
    const double start = steady_seconds();
    const double tick = sim_params_.step;
    const TickTimer odometry{1.0 / sim_params_.odom_rate, tick};
    const TickTimer joystick{1.0 / driver_params_.driver.rate, tick};
    const TickTimer extraction{extractor_params_.period, tick};
    const TickTimer planning{planner_params_.nmpc.control_period, tick};
    const TickTimer watchdog{0.4 * filter_params_.filter.control_period, tick};
    const TickTimer track{0.05, tick};
    for (long n = 1; !metrics_.finished() && !over(); ++n) {
      t_ = static_cast<double>(n) * tick;
      sim_.advance_to(t_);
      if (odometry.due(n)) sense();
      if (joystick.due(n)) person();
      if (extraction.due(n)) extract();
      if (nmpc_ && planning.due(n)) plan();
      if (joystick.due(n) || (nmpc_ && planning.due(n)))
        pass_on();
      else if (watchdog.due(n))
        send(filter_.update(localization_.state(t_), t_));
      measure(track.due(n));
      if (progress && n % 100 == 0) progress(progress_);
    }
    metrics_.write(log_.result);
    log_.result.wall_s = steady_seconds() - start;
    return std::move(log_);
  }

 private:
  [[nodiscard]] bool over() const { return t_ >= scenario_.duration; }

  void sense() {
    const OdometryReport report = sim_.odometry();
    localization_.on_odom(report.X_WB, report.twist, t_);
    localization_.on_transform(report.X_MW, t_);
  }

  void person() {
    const auto robot = localization_.state(t_);
    if (!driver_ || !robot) return;
    const bool leads = driver_params_.steers_leader && leader_;
    const Hand hand = driver_->steer(robot->X_MB, leads ? *leader_ : robot->X_MB, t_);
    const auto intent =
        teleop_.on_stick({hand.linear, hand.angular, !driver_->arrived(), false}, robot->X_MB, t_);
    if (!intent) return;
    user_ = intent->twist;
    leader_ = intent->X_ML;
    arbiter_.on_user(user_, t_);
  }

  void extract() {
    if (const auto robot = localization_.state(t_))
      obstacles_ = extractor_.near(robot->X_MB.position());
    remember(log_.obstacles, obstacles_);
  }

  void plan() {
    const auto robot = localization_.state(t_);
    if (!robot) return;
    PlanRequest request;
    request.method = method_named(planner_params_.method);
    request.t = t_;
    request.X_MB = robot->X_MB;
    request.command = sent_;
    request.measured = robot->twist;
    request.user = user_;
    request.obstacles = obstacles_;
    request.guidance = guidance_;
    if (const auto* goal = std::get_if<PoseGoal>(&scenario_.goal)) request.X_MG = goal->X_MG;
    if (request.method == Method::kLeader || request.method == Method::kPath) {
      if (!leader_) return;
      request.X_MG = *leader_;
    }
    count(nmpc_->solve(request));
  }

  void count(const Plan& plan) {
    DriveCounts& counts = log_.result.counts;
    ++counts.plans;
    if (plan.source != PlanSource::kSolution) ++counts.plan_fallbacks;
    counts.plan_ms.push_back(1e3 * plan.solve_time);
    progress_.plan_ms = counts.plan_ms.back();
    arbiter_.on_shared(plan.command, t_);
    arbiter_.on_clearance(plan.clearance, t_);
  }

  void pass_on() {
    filter_.on_command(arbiter_.decide(t_).command, t_);
    const Filtered out = filter_.update(localization_.state(t_), t_);
    DriveCounts& counts = log_.result.counts;
    ++counts.filter_commands;
    if (std::abs(out.requested.v - out.safe.v) > 1e-3 ||
        std::abs(out.requested.w - out.safe.w) > 1e-3)
      ++counts.filter_interventions;
    send(out);
  }

  void send(const Filtered& out) {
    sent_ = out.twist;
    sim_.command(out.twist, t_);
  }

  void measure(bool keep) {
    const SimState& truth = sim_.state();
    DriveSample sample{
        t_, truth.X_MB, truth.twist, user_, 0.0, static_cast<int>(sim_.contacts().count), leader_};
    sample.clearance = map_->clearance(sim_.footprint(), truth.X_MB, 1.0);
    metrics_.add(sample);
    if (keep) log_.track.push_back(sample);
    progress_ = {t_, truth.twist, sample.clearance, progress_.plan_ms, sample.collisions};
  }

  Scenario scenario_;
  DiffDriveSimNodeParams sim_params_;
  LocalPlannerNodeParams planner_params_;
  DriverNodeParams driver_params_;
  SafetyFilterNodeParams filter_params_;
  ObstacleExtractorNodeParams extractor_params_;
  std::shared_ptr<const StaticMap> map_;

  DiffDriveSim sim_;
  Localization localization_;
  std::optional<Driver> driver_;
  Teleop teleop_;
  Extractor extractor_;
  std::vector<GuidanceLine> guidance_;
  std::optional<Nmpc> nmpc_;
  Arbiter arbiter_;
  SafetyFilter filter_;

  double t_ = 0.0;
  Twist2 user_, sent_;
  std::optional<Pose2> leader_;
  std::vector<Obstacle> obstacles_;
  Metrics metrics_;
  DriveLog log_;
  Progress progress_;
};

}  // namespace

void check_drive(const Scenario& scenario, const DriveOptions& options) {
  const Scenario drive = with_options(scenario, options);
  try {
    Loop{drive, system_of(drive, options)}.check_start();
  } catch (const std::exception& error) {
    const std::string what = error.what();
    if (what.starts_with(drive.path)) throw;
    throw std::invalid_argument(drive.path + ": " + what);
  }
}

DriveLog drive_in_lockstep(const Scenario& scenario, const DriveOptions& options,
                           const std::function<void(const Progress&)>& progress) {
  const Scenario drive = with_options(scenario, options);
  DriveLog log = Loop{drive, system_of(drive, options)}.run(progress);
  log.result.scenario = drive.name;
  log.result.map = drive.map;
  log.result.method = drive.method;
  log.result.driver = drive.method == "goal" ? "none" : "route";
  log.result.seed = drive.seed;
  log.result.lockstep = true;
  log.result.failures = failures(drive, log.result);
  return log;
}

}  // namespace tandem
