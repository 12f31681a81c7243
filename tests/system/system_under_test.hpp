// SPDX-License-Identifier: Apache-2.0
// Runs a system (by default the forest) with one process per component, and a watcher node next to
// it.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/slow_motion.hpp"
#include "support/spin_until.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"

namespace tandem::test {

inline constexpr double kZeroWithin = 0.2;   // [s] simulated, from the fault to a zero command
inline constexpr double kBraking = 1.5;      // [m/s²] a_brake of bringup/robots/mir100.yaml
inline constexpr double kTurnBraking = 3.0;  // [rad/s²] alpha_brake
// [s] between two ground-truth messages: the resolution of measurements
inline constexpr double kOdomPeriod = 0.02;

inline const char* const kComponents[] = {"map_server",         "driver",        "teleop",
                                          "obstacle_extractor", "local_planner", "arbitration",
                                          "safety_filter",      "diff_drive_sim"};

class SystemUnderTest {
 public:
  explicit SystemUnderTest(std::string system = source_path("bringup/systems/forest.yaml"))
      : system_{std::move(system)} {
    cmd_vel_ = node_.create_subscription(topics::cmd_vel, [this](const auto& msg) {
      const auto twist = from_msg(msg);
      if (twist) command = *twist;
      ++commands;
    });
    truth_ = node_.create_subscription(topics::ground_truth, [this](const auto& msg) {
      const auto odometry = from_msg(msg);
      if (odometry) truth = *odometry;
      sim_time = rt::to_seconds(msg.header().stamp());
    });
    collision_ = node_.create_subscription(topics::collision,
                                           [this](const auto& msg) { collisions = msg.count(); });
    arbitration_ = node_.create_subscription(topics::arbitration_status, [this](const auto& msg) {
      reason = from_msg(msg.reason_code());
      deadman = msg.deadman();
    });
  }

  void start_all() {
    for (const char* name : kComponents) start(name);
  }
  void start(const std::string& name, const std::vector<std::string>& ros_args = {}) {
    std::vector<std::string> arguments{"run", system_, "--only", name};
    arguments.insert(arguments.end(), ros_args.begin(), ros_args.end());
    if (name == "diff_drive_sim" && kSpeed < 1.0) {
      if (ros_args.empty()) arguments.emplace_back("--ros-args");
      arguments.insert(arguments.end(), {"-p", "speed_factor:=" + std::to_string(kSpeed)});
    }
    children_[name] = std::make_unique<ChildProcess>("../tandem", std::move(arguments));
  }
  void kill_hard(const std::string& name) {
    children_.at(name)->send(SIGKILL);
    (void)children_.at(name)->wait(2.0);
  }
  [[nodiscard]] ChildProcess& process(const std::string& name) { return *children_.at(name); }

  [[nodiscard]] const std::string& system() const { return system_; }

  /// The watcher node. Its callbacks run during the wait functions.
  [[nodiscard]] rt::Node& node() { return node_; }

  /// `timeout`: [s] simulated, at `kSpeed`.
  [[nodiscard]] bool wait_until(const std::function<bool()>& done, double timeout) {
    return spin_until(done, timeout / kSpeed, node_);
  }
  /// Waits until the robot drives straight and fast enough for a meaningful stop.
  [[nodiscard]] bool wait_until_driving() {
    return wait_until([this] { return truth.twist.v > 0.4 && command.v > 0.4; }, 40.0);
  }
  [[nodiscard]] bool stands() const {
    return std::abs(truth.twist.v) < 0.03 && std::abs(truth.twist.w) < 0.05;
  }

  Twist2 command;
  long commands = 0;
  Odometry truth;
  double sim_time = 0.0;
  unsigned collisions = 0;
  Reason reason = Reason::kNone;
  bool deadman = false;

 private:
  std::string system_;
  rt::Node node_{"watcher"};
  rt::Subscription cmd_vel_, truth_, collision_, arbitration_;
  std::map<std::string, std::unique_ptr<ChildProcess>> children_;
};

}  // namespace tandem::test
