// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/drive_monitor.hpp"

#include <stdexcept>
#include <utility>

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

}  // namespace

DriveMonitor::DriveMonitor(rt::Node& node, DriveObserver drive, OnProgress on_progress)
    : node_{node},
      drive_{std::move(drive)},
      on_progress_{std::move(on_progress)},
      started_{node.steady_now()},
      heard_{started_} {
  listen_to_robot();
  listen_to_person();
  listen_to_components();
  supervisor_ = node.create_wall_timer(0.2, [this] { supervise(); });
}

DriveLog DriveMonitor::finish(const std::string& scenario) const {
  if (!trouble_.empty()) throw std::runtime_error(scenario + ": " + trouble_);
  DriveLog log = drive_.log();
  log.result.wall_s = node_.steady_now() - started_;
  return log;
}

void DriveMonitor::listen_to_robot() {
  truth_ = node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
    heard_ = node_.steady_now();
    if (const auto truth = truth_from(msg, Frames{}.map))
      drive_.on_robot(*truth, rt::to_seconds(msg.header().stamp()));
    if (drive_.over()) node_.stop();
  });
  collision_ = node_.create_subscription(topics::collision,
                                         [this](const auto& msg) { drive_.on_collision(msg); });
}

void DriveMonitor::listen_to_person() {
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

void DriveMonitor::listen_to_components() {
  planner_ = node_.create_subscription(topics::planner_status,
                                       [this](const auto& msg) { drive_.on_plan(msg); });
  filter_ = node_.create_subscription(topics::filter_status,
                                      [this](const auto& msg) { drive_.on_filter(msg); });
  obstacles_ = node_.create_subscription(topics::obstacles,
                                         [this](const auto& msg) { drive_.on_obstacles(msg); });
}

void DriveMonitor::supervise() {
  const double now = node_.steady_now();
  if (!drive_.driving() && now - started_ > kStartLimit)
    fail("the robot receives no commands: is another system running in this ROS_DOMAIN_ID?");
  else if (now - heard_ > kSilence && drive_.driving())
    fail("odometry stopped arriving from the robot");
  if (rt::shutting_down()) node_.stop();
  if (on_progress_ && drive_.driving()) on_progress_(drive_.progress());
}

void DriveMonitor::fail(const char* why) {
  trouble_ = why;
  node_.stop();
}

}  // namespace tandem
