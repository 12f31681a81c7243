// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "tandem/io/diagnostics.hpp"
#include "tandem/io/map_input.hpp"
#include "tandem/io/obstacle_tracks_input.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/io/sensing_input.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/safety_filter/safety_filter.hpp"

namespace tandem {

struct SafetyFilterNodeParams {
  RobotParams robot;
  SafetyFilterParams filter;
  MapInputParams map;
  RobotStateParams input;
  StampParams stamp;
  bool stamped = false;
  bool odom_stamped = true;

  template <class Visitor>
  void visit(Visitor&& field) {
    robot.visit(field);
    filter.visit(field);
    map.visit(field);
    input.visit(field);
    stamp.visit(field);
    field("stamped", stamped,
          "true: cmd_vel is published as TwistStamped, as ros2_control and Nav2 expect");
    field("odom_stamped", odom_stamped,
          "true: odometry whose stamp is older than sensor_delay is treated as that old; set to "
          "false if the base's clock is not synchronized with this one");
  }
};

/// cmd_vel_arbitrated, octomap_binary, octomap_local, sensing_status, people, odom, tf → cmd_vel,
/// safety_filter/status, /diagnostics.
///
/// The last node before the wheels. Answers every command on arrival and publishes at least every
/// control period; publishes zero if an input is silent or in doubt. Throws std::invalid_argument
/// with enforce = false unless the clock is simulated: a real robot never runs without the filter.
class SafetyFilterNode {
 public:
  using Params = SafetyFilterNodeParams;

  explicit SafetyFilterNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void update();
  [[nodiscard]] Filtered next();
  [[nodiscard]] std::string why(const Filtered& out) const;  // reason with its details
  [[nodiscard]] const char* map_missing() const;
  void send(const Twist2& twist);
  void watch();
  void publish_status(const Filtered& out);
  void look_for_others();
  void diagnose();

  rt::Node& node_;
  rt::Parameters<SafetyFilterNodeParams> params_;
  SafetyFilter filter_;
  RobotStateInput robot_;
  MapInput map_;
  SensingInput sensing_;
  std::string blind_;  // why the sensed map cannot be trusted; empty if it can
  std::unique_ptr<ObstacleTracksInput> people_;  ///< set if people are tracked
  Filtered last_;
  std::uint64_t interventions_ = 0;
  double updated_ = 0.0;  ///< last update, steady time [s]

  rt::Publisher<geometry_msgs::msg::Twist> cmd_vel_;                 ///< used unless `stamped`
  rt::Publisher<geometry_msgs::msg::TwistStamped> cmd_vel_stamped_;  ///< used if `stamped`
  rt::Publisher<tandem_msgs::msg::FilterStatus> status_;
  Diagnostics diagnostics_;
  TwistInput command_;
  std::size_t others_ = 0;  // other publishers of cmd_vel
  rt::Timer watchdog_, looks_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
