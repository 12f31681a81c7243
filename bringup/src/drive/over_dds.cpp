// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/over_dds.hpp"

#include <memory>
#include <stdexcept>

#include "bringup/drive/drive_observer.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

constexpr double kStartLimit = 20.0;  // [s] of steady time for the drive to begin
constexpr double kSilence = 5.0;      // [s] of steady time without ground truth: drive failed

// cmd_vel_user may carry Twist or TwistStamped; the nodes accept both.
constexpr rt::Topic<geometry_msgs::msg::TwistStamped> kUserStamped{topics::cmd_vel_user.name,
                                                                   topics::cmd_vel_user.qos};

// Measures the drive from the topics of the nodes; publishes nothing.
class Monitor {
 public:
  Monitor(rt::Node& node, const Scenario& scenario, const System& system,
          const std::function<void(const Progress&)>& progress)
      : node_{node}, drive_{scenario, system}, progress_{progress} {
    listen_to_robot();
    listen_to_person();
    listen_to_components();
    started_ = heard_ = node.steady_now();
    supervisor_ = node.create_wall_timer(0.2, [this] { supervise(); });
  }

  DriveLog finish() {
    DriveLog log = drive_.log();
    log.result.wall_s = node_.steady_now() - started_;
    return log;
  }
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  void listen_to_robot() {
    truth_ = node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
      heard_ = node_.steady_now();
      if (const auto truth = truth_from(msg, Frames{}.map))
        drive_.on_robot(*truth, rt::to_seconds(msg.header().stamp()));
      if (drive_.over()) node_.stop();
    });
    collision_ = node_.create_subscription(topics::collision,
                                           [this](const auto& msg) { drive_.on_collision(msg); });
  }

  void listen_to_person() {
    user_ = node_.create_subscription(topics::cmd_vel_user, topics::kUserInput,
                                      [this](const auto& msg) { drive_.on_user(msg); });
    stamped_publishers_ = node_.watch_publishers(kUserStamped, [this](const auto& offered) {
      if (offered.empty())
        user_stamped_.reset();
      else if (!user_stamped_)
        user_stamped_ = node_.create_subscription(kUserStamped, topics::kUserInput,
                                                  [this](const auto& msg) { drive_.on_user(msg); });
    });
    leader_ = node_.create_subscription(topics::leader_pose, topics::kUserInput,
                                        [this](const auto& msg) { drive_.on_leader(msg); });
    end_ = node_.create_subscription(topics::end_sim, [this](const auto& msg) {
      if (msg.data()) node_.stop();
    });
  }

  void listen_to_components() {
    planner_ = node_.create_subscription(topics::planner_status,
                                         [this](const auto& msg) { drive_.on_plan(msg); });
    filter_ = node_.create_subscription(topics::filter_status,
                                        [this](const auto& msg) { drive_.on_filter(msg); });
    obstacles_ = node_.create_subscription(topics::obstacles,
                                           [this](const auto& msg) { drive_.on_obstacles(msg); });
  }

  void supervise() {
    const double now = node_.steady_now();
    if (!drive_.driving() && now - started_ > kStartLimit) {
      trouble_ = "the robot receives no commands: is another system running in this ROS_DOMAIN_ID?";
      node_.stop();
    } else if (now - heard_ > kSilence && drive_.driving()) {
      trouble_ = "odometry stopped arriving from the robot";
      node_.stop();
    }
    if (rt::shutting_down()) node_.stop();
    if (progress_ && drive_.driving()) progress_(drive_.progress());
  }

  rt::Node& node_;
  DriveObserver drive_;
  std::function<void(const Progress&)> progress_;
  double started_ = 0.0, heard_ = 0.0;
  std::string trouble_;

  rt::Subscription truth_, collision_, user_, leader_, end_, planner_, filter_, obstacles_;
  std::optional<rt::Subscription> user_stamped_;
  std::shared_ptr<void> stamped_publishers_;
  rt::Timer supervisor_;
};

}  // namespace

DriveLog drive_over_dds(const Scenario& scenario, const DriveOptions& options,
                        const std::function<void(const Progress&)>& progress) {
  const Scenario drive = with_options(scenario, options);
  const System system = system_of(drive, options);
  rt::Node node{"scenario"};
  Monitor monitor{node, drive, system, progress};
  RunningSystem running{system};
  node.spin();
  running.stop();
  running.wait();
  if (!monitor.trouble().empty()) throw std::runtime_error(drive.name + ": " + monitor.trouble());
  return monitor.finish();
}

}  // namespace tandem
