// SPDX-License-Identifier: Apache-2.0
#include "tandem/nav2_facade/nav2_facade_node.hpp"

#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr const char* kMethod = "goal";  // the planner's, which navigate_to_pose needs

// The lifecycle state of a node that is active if nothing is wrong.
lifecycle_msgs::msg::State state_if(const std::string& wrong) {
  namespace states = lifecycle_msgs::msg::State_Constants;
  lifecycle_msgs::msg::State state;
  state.id(wrong.empty() ? states::PRIMARY_STATE_ACTIVE : states::PRIMARY_STATE_INACTIVE);
  state.label(wrong.empty() ? "active" : "inactive");
  return state;
}

}  // namespace

rt::Interface Nav2FacadeNode::interface() {
  return rt::Interface{
             .subscribes = {topics::planner_status},
             .publishes = {topics::amcl_pose},
             .serves = {services::amcl_state, services::navigator_state,
                        services::localization_is_active, services::navigation_is_active}} +
         RobotStateInput::interface() + NavigationInput::interface();
}

Nav2FacadeNode::Nav2FacadeNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      robot_{node, params_->input},
      input_{node},
      amcl_pose_{node.create_publisher(topics::amcl_pose)},
      on_planner_{node.create_subscription(topics::planner_status,
                                           [this](const auto& msg) {
                                             method_ = {msg.method(), node_.now()};
                                           })},
      amcl_state_{node.create_service(services::amcl_state,
                                      [this](const auto&, auto& response) {
                                        response.current_state(state_if(why_not_localized()));
                                      })},
      navigator_state_{node.create_service(services::navigator_state,
                                           [this](const auto&, auto& response) {
                                             response.current_state(state_if(why_not_ready()));
                                           })},
      localization_is_active_{node.create_service(services::localization_is_active,
                                                  [this](const auto&, auto& response) {
                                                    response.message(why_not_localized());
                                                    response.success(response.message().empty());
                                                  })},
      navigation_is_active_{node.create_service(services::navigation_is_active,
                                                [this](const auto&, auto& response) {
                                                  response.message(why_not_ready());
                                                  response.success(response.message().empty());
                                                })},
      timer_{node.create_wall_timer(kPosePeriod, [this] { publish_pose(); })},
      time_jump_{node.on_time_jump([this] { method_.reset(); })} {}

std::string Nav2FacadeNode::why_not_localized() const {
  return robot_.state() ? "" : robot_.missing();
}

std::string Nav2FacadeNode::why_not_ready() const {
  NavigationState state = input_.state();
  if (method_.fresh(node_.now(), NavigationInput::kSilence)) state.method = method_.value;
  state.not_localized = why_not_localized();
  const auto hindrance = hindrance_to(kMethod, state);
  return hindrance ? in_words(*hindrance, kMethod, state) : "";
}

void Nav2FacadeNode::publish_pose() {
  const auto robot = robot_.state();
  if (!robot) return;
  geometry_msgs::msg::PoseWithCovarianceStamped msg;
  msg.header(header(node_.stamp(), params_->input.frames.map));
  msg.pose().pose(to_msg(robot->X_MB));
  amcl_pose_.publish(msg);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::Nav2FacadeNode, "nav2_facade")
