// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tandem/io/diagnostics.hpp"
#include "tandem/io/robot_description.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/local_planner/navigation_node.hpp"
#include "tandem/local_planner/navigation_params.hpp"
#include "tandem/local_planner/nmpc.hpp"
#include "tandem/local_planner/plan_inputs.hpp"
#include "tandem/map/virtual_fixtures.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// The parameters that may change while the node runs.
struct LivePlannerParams {
  NmpcParams nmpc;
  std::string method = "leader";

  template <class Visitor>
  void visit(Visitor&& field) {
    nmpc.visit(field);
    field("method", method, OneOf{{"leader", "intention", "path", "goal"}},
          "what the planner follows");
  }
};

struct LocalPlannerNodeParams {
  RobotParams robot;
  LivePlannerParams live;
  RobotStateParams input;
  std::vector<double> goal;
  std::string fixtures;
  PlanInputParams timeouts;
  StampParams stamp;
  bool publish_description = false;
  NavigationParams navigation;

  template <class Visitor>
  void visit(Visitor&& field) {
    robot.visit(field);
    live.visit(field);
    input.visit(field);
    field("goal", goal, Range{-1e5, 1e5},
          "[m, m, rad] initial goal of method goal; replaced by each goal_pose");
    field("fixtures", fixtures, "YAML file of guidance lines; empty: none");
    timeouts.visit(field);
    stamp.visit(field);
    field("publish_description", publish_description,
          "whether the robot's shape is published on robot_description, unless another node does");
    navigation.visit(field);
  }
};

/// The guidance lines of the file `fixtures`; empty without one. Throws
/// std::invalid_argument, as load_virtual_fixtures does.
[[nodiscard]] inline std::vector<GuidanceLine> guidance_of(const LocalPlannerNodeParams& params) {
  return params.fixtures.empty() ? std::vector<GuidanceLine>{}
                                 : load_virtual_fixtures(params.fixtures).guidance;
}

/// odom, tf, obstacles, cmd_vel and leader_pose | cmd_vel_user | goal_pose → cmd_vel_shared, plan,
/// user_path, planner/status, /diagnostics. Optional input: safety_filter/status, which reports
/// whether plans pass. With `serve_actions` goals also come from Nav2's actions.
///
/// Plans once per control period; the guidance lines of the file `fixtures` draw the reference.
/// While a required input is silent it publishes zero and the reason. A watchdog checks the inputs
/// four times per control period.
class LocalPlannerNode {
 public:
  using Params = LocalPlannerNodeParams;
  explicit LocalPlannerNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void change(const LivePlannerParams& wanted);
  void start_timers(double control_period);
  void start_watchdog(double control_period);
  void subscribe();
  void plan();
  void watch();
  void publish(const Plan& plan, const PlanRequest& request);
  void write_status(const Plan& plan);
  void write_reason(const std::string& reason);
  void publish_paths(const Plan& plan, const PlanRequest& request);
  void stop(Reason reason);
  void stop(const std::string& reason);

  rt::Node& node_;
  rt::Parameters<LocalPlannerNodeParams> params_;
  Method method_;
  PlanInputs inputs_;
  Nmpc nmpc_;
  RobotStateInput robot_;
  tandem_msgs::msg::PlannerStatus status_;

  rt::Publisher<geometry_msgs::msg::Twist> cmd_vel_shared_;
  rt::Publisher<nav_msgs::msg::Path> plan_, user_path_;
  rt::Publisher<tandem_msgs::msg::PlannerStatus> status_out_;
  Diagnostics diagnostics_;
  std::optional<RobotDescription> description_;
  StampCheck leader_stamp_;
  TwistInput on_user_, on_command_;
  rt::Subscription on_obstacles_, on_leader_, on_goal_, on_filter_;
  bool planning_ = false;
  rt::StateLog reasons_{node_.log(), 1.0};  ///< for standing
  std::optional<NavigationActions> navigation_;
  rt::Timer timer_;
  rt::Timer watchdog_;  // while planning_
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
