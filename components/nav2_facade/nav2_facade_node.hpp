// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "tandem/io/navigation_input.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct Nav2FacadeNodeParams {
  RobotStateParams input;

  template <class Visitor>
  void visit(Visitor&& field) {
    input.visit(field);
  }
};

/// Answers what clients of Nav2 ask before they send a goal to `navigate_to_pose`: whether
/// localiser and navigator are active. The navigator is while the planner would accept a goal.
/// odom, tf, arbitration/status, safety_filter/status, planner/status → amcl_pose.
class Nav2FacadeNode {
 public:
  using Params = Nav2FacadeNodeParams;
  static constexpr double kPosePeriod = 0.2;  ///< [s] between two poses

  explicit Nav2FacadeNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  [[nodiscard]] std::string why_not_localized() const;  // empty: it is
  [[nodiscard]] std::string why_not_ready() const;      // empty: it is
  void publish_pose();

  rt::Node& node_;
  rt::Parameters<Nav2FacadeNodeParams> params_;
  RobotStateInput robot_;
  NavigationInput input_;
  Stamped<std::string> method_;  // of the planner
  rt::Publisher<geometry_msgs::msg::PoseWithCovarianceStamped> amcl_pose_;
  rt::Subscription on_planner_;
  rt::Service amcl_state_, navigator_state_, localization_is_active_, navigation_is_active_;
  rt::Timer timer_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
