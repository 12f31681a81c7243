// SPDX-License-Identifier: Apache-2.0
#include "bringup/over_dds.hpp"

#include <stdexcept>

#include "convert.hpp"
#include "diff_drive_sim/diff_drive_sim_node.hpp"
#include "map/octomap_file.hpp"
#include "runtime/shutdown.hpp"
#include "topics.hpp"

namespace tandem {
namespace {

constexpr double kStartLimit = 20.0;  // [s] of steady time until the robot is heard
constexpr double kSilence = 5.0;      // [s] of steady time without the robot: broken

// Listens to what everyone says and measures; says nothing itself.
class Monitor {
 public:
  Monitor(rt::Node& node, const Scenario& scenario, const DiffDriveSimNodeParams& sim,
          const std::function<void(const Progress&)>& progress)
      : node_{node},
        scenario_{scenario},
        map_{slice(*load_octomap(sim.map), sim.slice), sim.unknown_is_obstacle},
        footprint_{footprint_of(sim.robot)},
        metrics_{scenario.goal, sim.robot.v_max, sim.robot.w_max},
        progress_{progress} {
    listen_to_robot();
    listen_to_person();
    listen_to_components();
    started_ = heard_ = node.steady_now();
    supervisor_ = node.create_wall_timer(0.2, [this] { supervise(); });
  }

  DriveLog finish() {
    metrics_.write(log_.result);
    log_.result.wall_s = node_.steady_now() - started_;
    return std::move(log_);
  }
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  void listen_to_robot() {
    truth_ = node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
      if (const auto truth = from_msg(msg)) measure(*truth, rt::to_seconds(msg.header().stamp()));
    });
    collision_ = node_.create_subscription(topics::collision, [this](const auto& msg) {
      sample_.collisions = static_cast<int>(msg.count());
    });
  }

  void listen_to_person() {
    user_ = node_.create_subscription(topics::cmd_vel_user, topics::kUserInput,
                                      [this](const auto& msg) {
                                        if (const auto twist = from_msg(msg)) sample_.user = *twist;
                                        driving_ = true;
                                      });
    leader_ =
        node_.create_subscription(topics::leader_pose, topics::kUserInput,
                                  [this](const auto& msg) { sample_.X_ML = from_msg(msg.pose()); });
    end_ = node_.create_subscription(topics::end_sim, [this](const auto& msg) {
      if (msg.data()) node_.stop();
    });
  }

  void listen_to_components() {
    planner_ = node_.create_subscription(topics::planner_status,
                                         [this](const auto& msg) { count_plan(msg); });
    filter_ = node_.create_subscription(topics::filter_status, [this](const auto& msg) {
      DriveCounts& counts = log_.result.counts;
      ++counts.filter_commands;
      counts.filter_interventions = static_cast<long>(msg.interventions());
    });
    obstacles_ = node_.create_subscription(topics::obstacles, [this](const auto& msg) {
      remember(log_.obstacles, from_msg(msg).all);
    });
  }

  void count_plan(const tandem_msgs::msg::PlannerStatus& msg) {
    DriveCounts& counts = log_.result.counts;
    if (static_cast<long>(msg.cycles()) == counts.plans) return;  // said why it stands
    counts.plans = static_cast<long>(msg.cycles());
    counts.plan_fallbacks = static_cast<long>(msg.fallbacks());
    counts.plan_overruns = static_cast<long>(msg.overruns());
    counts.plan_ms.push_back(1e3 * msg.solve_time());
    if (scenario_.method == "goal") driving_ = true;
  }

  // The drive begins when someone drives, not while the nodes still find each other.
  void measure(const Odometry& truth, double t) {
    heard_ = node_.steady_now();
    sample_.t = t;
    sample_.X_MB = truth.X;
    sample_.twist = truth.twist;
    sample_.clearance = map_.clearance(footprint_, truth.X, 1.0);
    if (!driving_) return;
    if (!first_) first_ = t;
    metrics_.add(sample_);
    if (log_.track.empty() || t - log_.track.back().t >= 0.05) log_.track.push_back(sample_);
    if (metrics_.finished() || t - *first_ >= scenario_.duration) node_.stop();
  }

  void supervise() {
    const double now = node_.steady_now();
    if (!driving_ && now - started_ > kStartLimit) {
      trouble_ = "nobody drives: is another system running in this ROS_DOMAIN_ID?";
      node_.stop();
    } else if (now - heard_ > kSilence && driving_) {
      trouble_ = "the robot fell silent";
      node_.stop();
    }
    if (rt::shutting_down()) node_.stop();
    if (!progress_ || !driving_) return;
    const auto& ms = log_.result.counts.plan_ms;
    progress_({sample_.t, sample_.twist, sample_.clearance, ms.empty() ? 0.0 : ms.back(),
               sample_.collisions});
  }

  rt::Node& node_;
  Scenario scenario_;
  StaticMap map_;
  Footprint footprint_;
  Metrics metrics_;
  std::function<void(const Progress&)> progress_;

  DriveLog log_;
  DriveSample sample_;
  bool driving_ = false;
  std::optional<double> first_;
  double started_ = 0.0, heard_ = 0.0;
  std::string trouble_;

  rt::Subscription truth_, collision_, user_, leader_, end_, planner_, filter_, obstacles_;
  rt::Timer supervisor_;
};

}  // namespace

DriveLog drive_over_dds(const Scenario& scenario, const DriveOptions& options,
                        const std::function<void(const Progress&)>& progress) {
  const Scenario drive = with_options(scenario, options);
  const System system = system_of(drive, options);
  rt::Node node{"scenario"};
  Monitor monitor{node, drive, parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim"),
                  progress};
  RunningSystem running{system};
  node.spin();
  running.stop();
  running.wait();
  if (!monitor.trouble().empty()) throw std::runtime_error(drive.name + ": " + monitor.trouble());
  DriveLog log = monitor.finish();
  log.result.scenario = drive.name;
  log.result.map = drive.map;
  log.result.method = drive.method;
  log.result.driver = drive.method == "goal" ? "none" : "route";
  log.result.seed = drive.seed;
  log.result.failures = failures(drive, log.result);
  return log;
}

}  // namespace tandem
