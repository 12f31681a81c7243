// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/drive_observer.hpp"

#include "bringup/scenario/method.hpp"
#include "bringup/scenario/shortest_path.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

constexpr double kTrackPeriod = 0.05;  // [s]

DiffDriveSimNodeParams sim_of(const System& system) {
  return parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim");
}

}  // namespace

DriveObserver::DriveObserver(const Scenario& scenario, const System& system,
                             const DriveWorld& world)
    : scenario_{scenario},
      map_{world.map},
      footprint_{footprint_of(sim_of(system).robot)},
      metrics_{metrics_setting(scenario, system, world.shortest_path)} {
  log_.result.scenario = scenario.name;
  log_.result.map = scenario.map;
  log_.result.method = scenario.method;
  log_.result.driver = driver_of(scenario);
  log_.result.seed = scenario.seed;
}

void DriveObserver::on_robot(const Odometry& robot, double t) {
  sample_.t = t;
  sample_.X_MB = robot.X;
  sample_.twist = robot.twist;
  sample_.clearance = map_->clearance(footprint_, robot.X, kFarClearance);
  if (!driving_) return;
  if (!first_) first_ = t;
  metrics_.add(sample_);
  if (log_.track.empty() || t - log_.track.back().t >= kTrackPeriod) log_.track.push_back(sample_);
}

void DriveObserver::on_collision(const tandem_msgs::msg::Collision& msg) {
  const long more = collisions_.growth(msg.count());
  const long walked_into = walked_into_.growth(msg.walked_into());
  if (!driving_) return;
  sample_.collisions += static_cast<int>(more);
  log_.result.walked_into = log_.result.walked_into.value_or(0) + static_cast<int>(walked_into);
}

void DriveObserver::on_user(const geometry_msgs::msg::Twist& msg) {
  if (const auto twist = from_msg(msg)) sample_.user = *twist;
  driving_ = true;
}

void DriveObserver::on_leader(const geometry_msgs::msg::PoseStamped& msg) {
  sample_.X_ML = from_msg(msg.pose());
}

void DriveObserver::on_plan(const tandem_msgs::msg::PlannerStatus& msg) {
  const bool just_begun = msg.cycles() <= 1;
  const long plans = plans_.growth(msg.cycles(), just_begun);
  const long fallbacks = fallbacks_.growth(msg.fallbacks(), just_begun);
  const long overruns = overruns_.growth(msg.overruns(), just_begun);
  if (plans == 0) return;  // the status only reports why the robot stands
  if (!has_person(drive_method(scenario_.method))) driving_ = true;
  if (!driving_) return;
  DriveCounts& counts = log_.result.counts;
  counts.plans += plans;
  counts.plan_fallbacks += fallbacks;
  counts.plan_overruns += overruns;
  counts.plan_ms.push_back(1e3 * msg.solve_time());
}

// A filter that does not enforce passes the commands that it would change, so only its total of
// interventions shows them.
void DriveObserver::on_filter(const tandem_msgs::msg::FilterStatus& msg) {
  const bool changed = interventions_.growth(msg.interventions()) > 0;
  if (!driving_ || from_msg(msg.reason_code()) == Reason::kNoCommand) return;
  log_.result.counts.on_filtered(rt::to_seconds(msg.header().stamp()), changed);
}

void DriveObserver::on_obstacles(const tandem_msgs::msg::ObstacleArray& msg) {
  remember(log_, from_msg(msg).all);
}

bool DriveObserver::over() const {
  return metrics_.finished() || (first_ && sample_.t - *first_ >= scenario_.duration);
}

Progress DriveObserver::progress() const {
  const auto& ms = log_.result.counts.plan_ms;
  return {sample_.t, sample_.twist, sample_.clearance, ms.empty() ? 0.0 : ms.back(),
          sample_.collisions};
}

DriveLog DriveObserver::log() const {
  DriveLog log = log_;
  metrics_.write(log.result);
  log.result.failures = failures(scenario_, log.result);
  return log;
}

}  // namespace tandem
