// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/safety_filter_node.hpp"

#include <cmath>

#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kRepeat = 0.5;      // [control periods] after an output, the next one is made
constexpr double kPollPeriod = 1.0;  // [s] between two checks for other publishers of cmd_vel

// The topic whose silence causes this reason; empty if none does.
const char* topic_missing(FilterReason reason) {
  if (reason == FilterReason::kNoCommand) return topics::cmd_vel_arbitrated.name;
  if (reason == FilterReason::kNotLocalized) return topics::odom.name;
  return reason == FilterReason::kNoPeople ? topics::people.name : "";
}

}  // namespace

rt::Interface SafetyFilterNode::interface() {
  return TwistInput::interface(topics::cmd_vel_arbitrated) + MapInput::interface() +
         SensingInput::interface() + RobotStateInput::interface() +
         rt::only_if("people: true", ObstacleTracksInput::interface()) +
         rt::Interface{.publishes = {{topics::cmd_vel, "stamped: false"},
                                     {topics::cmd_vel_stamped, "stamped: true"},
                                     topics::filter_status}} +
         Diagnostics::interface();
}

SafetyFilterNode::SafetyFilterNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      filter_{params_->filter, params_->robot},
      robot_{node, params_->input},
      map_{node, params_->map, robot_.frames(), UnseenGround::kHeeded},
      sensing_{node, params_->map},
      status_{node.create_publisher(topics::filter_status)},
      diagnostics_{node, {topics::cmd_vel.name, topics::filter_status.name}},
      command_{node, topics::cmd_vel_arbitrated, params_->stamp, [this](const Twist2& twist) {
                 filter_.on_command(twist, node_.now());
                 update();
               }} {
  // A publisher of /clock would decide how old messages are, and to open a topic takes time.
  node.fix_common_parameters();
  if (!params_->filter.enforce && !node.use_sim_time())
    throw std::invalid_argument(
        "enforce = false is for simulated studies (use_sim_time: true); a robot keeps its filter");
  command_.set_frames(params_->input.frames);
  command_.pass_not_finite();  // the core stops and reports the reason
  map_.on_live_map([this] { update(); });
  robot_.on_state([this](const RobotState& state) { filter_.on_state(state, node_.now()); });
  if (params_->odom_stamped) robot_.use_stamps(params_->robot.sensor_delay);
  if (params_->filter.people.watched)
    people_ = std::make_unique<ObstacleTracksInput>(node, robot_.frames(), [this](auto people) {
      filter_.on_people(std::move(people), node_.now());
    });
  if (params_->stamped)
    cmd_vel_stamped_ = node.create_publisher(topics::cmd_vel_stamped);
  else
    cmd_vel_ = node.create_publisher(topics::cmd_vel);
  looks_ = node.create_wall_timer(kPollPeriod, [this] { look_for_others(); });
  watchdog_ = node.create_wall_timer(0.4 * params_->filter.control_period, [this] { watch(); });
  time_jump_ = node.on_time_jump([this] { filter_.on_time_jump(node_.now()); });
}

void SafetyFilterNode::update() {
  const Filtered out = next();
  if (out.reason != last_.reason) node_.log().debug("{}", why(out));
  if (out.twist_contradicted)
    node_.log().warn_every(
        5.0,
        "odom's twist contradicts the motion of its poses: braking assumes the worse of the two; "
        "nav_msgs/Odometry requires the twist in child_frame_id, forward positive");
  last_ = out;
  updated_ = node_.steady_now();
  watchdog_.skip_until(updated_ + kRepeat * params_->filter.control_period);
  send(out.twist);
  publish_status(out);
  diagnose();
}

Filtered SafetyFilterNode::next() {
  if (node_.clock_is_silent()) {
    node_.log().warn_every(10.0, "/clock is silent: stopping");
    return filter_.stop(FilterReason::kClockSilent, node_.now());
  }
  const auto robot = robot_.state();
  const auto map = map_.map(robot);
  blind_ = sensing_.trouble();
  if (blind_.empty())
    filter_.on_map(map, map_.unseen());
  else
    filter_.on_map(nullptr);
  return filter_.update(robot, node_.now());
}

std::string SafetyFilterNode::why(const Filtered& out) const {
  if (out.reason == FilterReason::kNotLocalized)
    if (const std::string trouble = robot_.frame_trouble(); !trouble.empty())
      return std::string{name(out.reason)} + ": " + trouble;
  if (out.reason != FilterReason::kNoMap) return name(out.reason);
  return blind_.empty() ? map_.missing() : blind_;
}

// The topic whose absence leaves the filter without a map.
const char* SafetyFilterNode::map_missing() const {
  return blind_.empty() ? map_.missing_topic() : topics::sensing_status.name;
}

void SafetyFilterNode::send(const Twist2& twist) {
  if (!params_->stamped) return cmd_vel_.publish(to_msg(twist));
  geometry_msgs::msg::TwistStamped msg;
  msg.header(header(node_.stamp(), params_->input.frames.base));
  msg.twist(to_msg(twist));
  cmd_vel_stamped_.publish(msg);
}

// Updates half a control period after the last output at the latest, so that one late timer tick
// does not break the promised period.
void SafetyFilterNode::watch() {
  if (node_.steady_now() - updated_ >= kRepeat * params_->filter.control_period) update();
}

void SafetyFilterNode::publish_status(const Filtered& out) {
  const bool changed = std::abs(out.requested.v - out.safe.v) > 1e-3 ||
                       std::abs(out.requested.w - out.safe.w) > 1e-3;
  if (changed) ++interventions_;
  tandem_msgs::msg::FilterStatus msg;
  msg.header(header(node_.stamp(), params_->input.frames.map));
  msg.reason(why(out));
  msg.reason_code(to_msg(reason_in(msg.reason())));
  msg.scale(out.scale);
  msg.clearance(out.clearance);
  msg.enforcing(params_->filter.enforce);
  msg.refused(out.refused);
  msg.requested(to_msg(out.requested));
  msg.passed(to_msg(out.twist));
  msg.interventions(interventions_);
  status_.publish(msg);
}

// Another publisher on cmd_vel bypasses this filter.
void SafetyFilterNode::look_for_others() {
  const std::size_t all = node_.count_publishers(topics::cmd_vel.name);
  others_ = all > 0 ? all - 1 : 0;
  if (others_ > 0)
    node_.log().error_every(5.0,
                            "cmd_vel has {} publishers besides this filter, and the base may obey "
                            "them (a killed process still counts for 20 s); remap them to "
                            "cmd_vel_nav or cmd_vel_user, or give each robot a namespace",
                            others_);
}

void SafetyFilterNode::diagnose() {
  if (others_ > 0) return diagnostics_.report_trouble(text_of(Reason::kOthersDrive));
  if (!params_->filter.enforce) {
    node_.log().warn_every(10.0, "not enforcing: commands pass unchanged");
    return diagnostics_.report_trouble(text_of(Reason::kNotEnforcing));
  }
  if (last_.reason < FilterReason::kNoCommand) return diagnostics_.report_well(why(last_));
  diagnostics_.report_trouble(why(last_), last_.reason == FilterReason::kNoMap
                                              ? map_missing()
                                              : topic_missing(last_.reason));
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::SafetyFilterNode, "safety_filter")
