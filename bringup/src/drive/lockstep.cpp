// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/lockstep.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "bringup/drive/drive_world.hpp"
#include "bringup/scenario/shortest_path.hpp"
#include "tandem/arbitration/arbiter.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/driver/driver_node.hpp"
#include "tandem/hindsight/hindsight_node.hpp"
#include "tandem/local_planner/local_planner_node.hpp"
#include "tandem/obstacle_extractor/obstacle_extractor_node.hpp"
#include "tandem/octomap_builder/octomap_builder_node.hpp"
#include "tandem/safety_filter/safety_filter_node.hpp"
#include "tandem/shared_dwa/shared_dwa_node.hpp"
#include "tandem/teleop/teleop_node.hpp"

namespace tandem {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// CPU time of this process so far, user and system [s].
double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

bool has(const System& system, const std::string& component) {
  for (const auto& node : system.nodes)
    if (node.component == component) return true;
  return false;
}

Teleop teleop_of(const System& system) {
  const auto params = parameters_of<TeleopNodeParams>(system, "teleop");
  return Teleop{params.teleop, params.robot};
}

// Fires with a fixed period of simulated time, counted in ticks so that it does not drift.
class TickTimer {
 public:
  TickTimer(double period, double tick) : ticks_{std::max(1L, std::lround(period / tick))} {}
  [[nodiscard]] bool due(long tick) const { return tick % ticks_ == 0; }

 private:
  long ticks_;
};

// Connects the components' cores as topics connect the nodes.
class Loop {
 public:
  Loop(const Scenario& scenario, const System& system, const DriveOptions& options, Worlds& worlds)
      : scenario_{scenario},
        sim_params_{parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim")},
        planner_params_{parameters_of<LocalPlannerNodeParams>(system, "local_planner")},
        driver_params_{parameters_of<DriverNodeParams>(system, "driver")},
        filter_params_{parameters_of<SafetyFilterNodeParams>(system, "safety_filter")},
        extractor_params_{parameters_of<ObstacleExtractorNodeParams>(system, "obstacle_extractor")},
        world_{worlds.of(scenario, system, options)},
        map_{world_.truth},
        sim_{sim_params_.sim, sim_params_.robot, map_, scenario.seed},
        localization_{filter_params_.input.localization},
        teleop_{teleop_of(system)},
        extractor_{world_.extractor},
        plan_inputs_{planner_params_.timeouts, guidance_of(planner_params_)},
        arbiter_{parameters_of<ArbiterParams>(system, "arbitration")},
        filter_{filter_params_.filter, filter_params_.robot},
        metrics_{metrics_setting(scenario, system, world_.shortest_path)} {
    if (has(system, "driver"))
      driver_.emplace(driver_params_.driver, scenario.seed), driver_->on_map(map_);
    if (has(system, "local_planner"))
      nmpc_.emplace(planner_params_.live.nmpc, planner_params_.robot);
    if (has(system, "shared_dwa")) {
      const auto dwa = parameters_of<SharedDwaNodeParams>(system, "shared_dwa");
      dwa_.emplace(dwa.dwa, dwa.robot);
      planning_period_ = dwa.dwa.control_period;
    }
    if (has(system, "hindsight")) {
      const auto params = parameters_of<HindsightNodeParams>(system, "hindsight");
      hindsight_.emplace(params.hindsight, params.robot);
      hindsight_->on_map(*map_);
    }
    if (options.obstacles) sim_.put(people_of(sim_params_));
    sim_.reset(scenario.start, scenario.seed);
    extractor_.put_down();
    if (!is_live()) {
      known_ = world_.filter_map;
      filter_.on_map(known_);
      return;
    }
    base_ = base_of(sim_params_, filter_params_.map);
    known_ground_ = known_ground_of(sim_params_, filter_params_.map);
    live_.emplace(parameters_of<OctomapBuilderNodeParams>(system, "octomap_builder"));
  }

  // Throws std::invalid_argument if the start is in an obstacle or the map's slice has no occupied
  // cell, which hints at wrong slice heights.
  void check_start() const {
    const auto& slice = sim_params_.slice;
    const auto& cells = map_->grid().cells;
    if (!sim_params_.unknown_is_obstacle &&
        std::find(cells.begin(), cells.end(), Cell::kOccupied) == cells.end())
      throw std::invalid_argument(
          fmt::format("{} contains nothing between {} m and {} m above the floor at {} m; check "
                      "z_min, z_max and floor",
                      scenario_.map, slice.z_min, slice.z_max, slice.floor));
    const Pose2& X = scenario_.start;
    if (map_->clearance(sim_.footprint(), X, 1.0) <= 0.0)
      throw std::invalid_argument(fmt::format(
          "start: at [{}, {}, {}] the robot's outline overlaps an obstacle", X.x, X.y, X.theta));
  }

  DriveLog run(const std::function<void(const Progress&)>& progress) {
    const double start = steady_seconds();
    const double tick = sim_params_.step;
    const TickTimer odometry{1.0 / sim_params_.odom_rate, tick};
    const TickTimer scanner{1.0 / sim_params_.scan_rate, tick};
    const TickTimer joystick{1.0 / driver_params_.driver.navigator.rate, tick};
    const TickTimer extraction{extractor_params_.period, tick};
    const TickTimer planning{planning_period_, tick};
    const TickTimer watchdog{0.4 * filter_params_.filter.control_period, tick};
    const TickTimer track{0.05, tick};
    PartTimes& spent = log_.result.part_s;
    for (long n = 1; !metrics_.finished() && !over(); ++n) {
      t_ = static_cast<double>(n) * tick;
      timed(spent.simulator, [&] { sim_.advance_to(t_); });
      if (odometry.due(n)) sense();
      if (live_ && scanner.due(n)) timed(spent.extractor, [&] { look(); });
      if (joystick.due(n)) timed(spent.person, [&] { person(); });
      if (extraction.due(n)) timed(spent.extractor, [&] { extract(); });
      if (plans() && planning.due(n)) timed(spent.planner, [&] { plan(); });
      if (joystick.due(n) || (plans() && planning.due(n)))
        timed(spent.filter, [&] { pass_on(); });
      else if (watchdog.due(n))
        timed(spent.filter, [&] { send(filter_.update(localization_.state(t_), t_)); });
      timed(spent.measures, [&] { measure(track.due(n)); });
      if (progress && n % 100 == 0) progress(progress_);
    }
    metrics_.write(log_.result);
    log_.result.walked_into = static_cast<int>(sim_.contacts().walked_into);
    log_.result.wall_s = steady_seconds() - start;
    return std::move(log_);
  }

 private:
  [[nodiscard]] bool is_live() const { return is_seen_live(filter_params_.map); }

  template <class Work>
  static void timed(double& spent, Work work) {
    const double start = steady_seconds();
    work();
    spent += steady_seconds() - start;
  }

  [[nodiscard]] bool over() const { return t_ >= scenario_.duration; }

  [[nodiscard]] bool plans() const { return nmpc_ || dwa_; }

  void sense() {
    const OdometryReport report = sim_.odometry();
    localization_.on_odom(report.X_WB, report.twist, t_);
    localization_.on_transform(report.X_MW, t_);
    filter_.on_people(sim_.people().all(), t_);
    if (const auto robot = localization_.state(t_); live_ && robot)
      live_->on_odometry(*robot, report.X_WB, report.t, t_);
  }

  void look() {
    const auto scan = scan_of(sim_, sim_params_);
    const auto seen = live_->look(scan.scan(), filter_params_.map.slice, t_);
    const auto robot = localization_.state(t_);
    if (!live_->trouble(t_).empty()) return filter_.on_map(nullptr);
    if (!seen || !robot) return;
    const Eigen::Vector2d p_MB = robot->X_MB.position();
    const auto map = local_map_over(base_, *seen, p_MB, filter_params_.map);
    filter_.on_map(map, unseen_ground_over(known_ground_, *seen, p_MB, filter_params_.map));
    known_ = map;
    extractor_.update(map);
    (void)extractor_.refresh_near(p_MB, extractor_params_.extractor.range, 5);
  }

  void person() {
    const auto robot = localization_.state(t_);
    if (!driver_ || !robot) return;
    const bool leads = driver_params_.steers_leader && leader_;
    const Hand hand = driver_->steer(robot->X_MB, leads ? *leader_ : robot->X_MB, t_);
    const auto intent = teleop_.on_stick({hand.linear, hand.angular, hand.holds, false},
                                         robot->X_MB, t_, robot->twist);
    if (!intent) return;
    user_ = asked_ = intent->twist;
    if (hindsight_) asked_ = hindsight_->assist(robot->X_MB, user_, t_).command;
    leader_ = intent->X_ML;
    arbiter_.on_user(user_, t_);
  }

  void extract() {
    if (const auto robot = localization_.state(t_))
      obstacles_ = extractor_.near(robot->X_MB.position());
    if (extractor_params_.people) {
      const auto& people = sim_.people().all();
      obstacles_.insert(obstacles_.end(), people.begin(), people.end());
    }
    remember(log_, obstacles_);
  }

  void plan() {
    const auto robot = localization_.state(t_);
    if (!robot) return;
    if (dwa_) return known_ ? choose(*robot) : void();
    inform_planner();
    const Method method = method_named(planner_params_.live.method);
    const bool follows_leader = method == Method::kLeader || method == Method::kPath;
    if (follows_leader && !leader_) return;  // teleop gave no leader with its last command
    if (plan_inputs_.missing(method, t_)) return;
    count(nmpc_->solve(plan_inputs_.request(method, *robot, t_)));
  }

  // All inputs count as received now, so that no time-out of the planner ends a drive in lockstep.
  void inform_planner() {
    plan_inputs_.on_command(sent_, t_);
    plan_inputs_.on_user(asked_, t_);
    plan_inputs_.on_obstacles(obstacles_, t_);
    plan_inputs_.on_filter(filter_params_.filter.enforce, refused_, t_);
    if (leader_) plan_inputs_.on_leader(*leader_, t_);
    if (const auto* goal = std::get_if<PoseGoal>(&scenario_.goal)) plan_inputs_.on_goal(goal->X_MG);
  }

  void choose(const RobotState& robot) {
    const double start = steady_seconds();
    const DwaChoice choice = dwa_->choose(robot.X_MB, robot.twist, user_, *known_);
    Plan plan;
    plan.command = choice.command;
    plan.clearance = choice.clearance;
    plan.source = choice.admissible ? PlanSource::kSolution : PlanSource::kBraking;
    plan.solve_time = steady_seconds() - start;
    count(plan);
  }

  void count(const Plan& plan) {
    DriveCounts& counts = log_.result.counts;
    ++counts.plans;
    if (is_fallback(plan.source)) ++counts.plan_fallbacks;
    teleop_.keep_leader_near(plan.source == PlanSource::kYielded);
    counts.plan_ms.push_back(1e3 * plan.solve_time);
    progress_.plan_ms = counts.plan_ms.back();
    arbiter_.on_shared(plan.command, t_);
    arbiter_.on_clearance(plan.clearance, t_);
  }

  void pass_on() {
    filter_.on_command(arbiter_.decide(t_).command, t_);
    send(filter_.update(localization_.state(t_), t_));
  }

  void send(const Filtered& out) {
    if (out.reason != FilterReason::kNoCommand)
      log_.result.counts.on_filtered(t_, std::abs(out.requested.v - out.safe.v) > 1e-3 ||
                                             std::abs(out.requested.w - out.safe.w) > 1e-3);
    sent_ = out.twist;
    refused_ = out.refused;
    sim_.command(out.twist, t_);
  }

  void measure(bool keep) {
    const SimState& truth = sim_.state();
    DriveSample sample{
        t_, truth.X_MB, truth.twist, user_, 0.0, static_cast<int>(sim_.contacts().count), leader_};
    sample.clearance = map_->clearance(sim_.footprint(), truth.X_MB, kFarClearance);
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
  World& world_;
  std::shared_ptr<const StaticMap> map_;

  DiffDriveSim sim_;
  Localization localization_;
  std::optional<Driver> driver_;
  Teleop teleop_;
  Extractor& extractor_;
  Grid base_, known_ground_;
  std::optional<LiveSensing> live_;
  PlanInputs plan_inputs_;
  std::optional<Nmpc> nmpc_;
  std::optional<SharedDwa> dwa_;
  std::optional<Hindsight> hindsight_;
  double planning_period_ = planner_params_.live.nmpc.control_period;
  std::shared_ptr<const StaticMap> known_;  // the map that the filter uses
  Arbiter arbiter_;
  SafetyFilter filter_;

  double t_ = 0.0;
  Twist2 user_, asked_, sent_;  // from the person; input of the planner; to the base
  bool refused_ = false;        // the filter refused the last command
  std::optional<Pose2> leader_;
  std::vector<Obstacle> obstacles_;
  Metrics metrics_;
  DriveLog log_;
  Progress progress_;
};

}  // namespace

void check_drive(const Scenario& scenario, const DriveOptions& options) {
  Lockstep{}.check(scenario, options);
}

void Lockstep::check(const Scenario& scenario, const DriveOptions& options) {
  const Scenario drive = with_options(scenario, options);
  try {
    Loop{drive, system_of(drive, options), options, *worlds_}.check_start();
  } catch (const std::exception& error) {
    const std::string what = error.what();
    if (what.starts_with(drive.path)) throw;
    throw std::invalid_argument(drive.path + ": " + what);
  }
}

Lockstep::Lockstep() : worlds_{std::make_unique<Worlds>()} {}
Lockstep::~Lockstep() = default;

DriveLog drive_in_lockstep(const Scenario& scenario, const DriveOptions& options,
                           const std::function<void(const Progress&)>& progress) {
  return Lockstep{}.drive(scenario, options, progress);
}

DriveLog Lockstep::drive(const Scenario& scenario, const DriveOptions& options,
                         const std::function<void(const Progress&)>& progress) {
  const double start = steady_seconds(), cpu_start = cpu_seconds();
  const Scenario drive = with_options(scenario, options);
  Loop loop{drive, system_of(drive, options), options, *worlds_};
  const double ready = steady_seconds();
  DriveLog log = loop.run(progress);
  log.result.part_s.setup = ready - start;
  log.result.cpu_s = cpu_seconds() - cpu_start;
  log.result.scenario = drive.name;
  log.result.map = drive.map;
  log.result.method = drive.method;
  log.result.driver = driver_of(drive);
  log.result.seed = drive.seed;
  log.result.lockstep = true;
  log.result.failures = failures(drive, log.result);
  return log;
}

}  // namespace tandem
