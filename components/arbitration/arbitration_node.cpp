// SPDX-License-Identifier: Apache-2.0
#include "arbitration/arbitration_node.hpp"

#include "runtime/component.hpp"
#include "topics.hpp"

namespace tandem {

ArbitrationNode::ArbitrationNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<ArbiterParams>()},
      arbiter_{*params_},
      cmd_vel_arbitrated_{node.create_publisher(topics::cmd_vel_arbitrated)},
      status_{node.create_publisher(topics::arbitration_status)} {
  subscribe_commands();
  subscribe_emergency_stop();
  offer_services();
  watchdog_ = node.create_wall_timer(kWatchdog, [this] { watch(); });
  status_timer_ = node.create_wall_timer(kStatusPeriod, [this] { publish_status(); });
}

void ArbitrationNode::subscribe_commands() {
  const auto accept = [this](const geometry_msgs::msg::Twist& msg, const char* topic,
                             void (Arbiter::*receive)(const Twist2&, double), Source source) {
    const auto twist = from_msg(msg);
    if (!twist) {
      node_.log().warn_every(1.0, "{} is not finite: dropped", topic);
      return;
    }
    (arbiter_.*receive)(*twist, node_.now());
    decide(source);
  };
  user_ = node_.create_subscription(
      topics::cmd_vel_user, topics::kUserInput,
      [accept](const auto& msg) { accept(msg, "cmd_vel_user", &Arbiter::on_user, Source::kUser); });
  shared_ = node_.create_subscription(topics::cmd_vel_shared, [accept](const auto& msg) {
    accept(msg, "cmd_vel_shared", &Arbiter::on_shared, Source::kShared);
  });
  nav_ = node_.create_subscription(topics::cmd_vel_nav, [accept](const auto& msg) {
    accept(msg, "cmd_vel_nav", &Arbiter::on_nav, Source::kNav);
  });
  planner_ = node_.create_subscription(topics::planner_status, [this](const auto& msg) {
    arbiter_.on_clearance(msg.clearance(), node_.now());
  });
}

// Read twice: a latched reader never matches a volatile writer, and a stop must be heard from both.
void ArbitrationNode::subscribe_emergency_stop() {
  const auto on_stop = [this](const std_msgs::msg::Bool& msg) {
    if (msg.data() && !arbiter_.emergency_stopped()) node_.log().warn("emergency stop");
    arbiter_.on_emergency_stop(msg.data());
    decide(Source::kNone);
  };
  stop_latched_ = node_.create_subscription(topics::e_stop, on_stop);
  stop_any_ = node_.create_subscription(topics::e_stop, rt::kBestEffort(10), on_stop);
}

void ArbitrationNode::offer_services() {
  set_policy_ =
      node_.create_service(services::set_policy, [this](const auto& request, auto& response) {
        try {
          arbiter_.set_policy(policy_from(request.policy()));
          response.success(true);
          response.message("policy is now " + request.policy());
          node_.log().info("policy is now {}", request.policy());
        } catch (const std::invalid_argument& error) {
          response.success(false);
          response.message(error.what());
        }
      });
  release_ =
      node_.create_service(services::release_emergency_stop, [this](const auto&, auto& response) {
        response.success(arbiter_.release_emergency_stop());
        response.message(response.success() ? "released" : "e_stop still says true");
        node_.log().info("release of the emergency stop: {}", response.message());
      });
}

// A command goes on when the source that arrived is in charge; whatever stops goes on at once.
void ArbitrationNode::decide(Source arrived) {
  const Decision decision = arbiter_.decide(node_.now());
  const bool in_charge = decision.source == arrived || decision.source == Source::kNone ||
                         (decision.source == Source::kBlend && arrived == Source::kUser);
  if (decision.reason != decision_.reason)
    node_.log().info("{}: {}", name(decision.source), name(decision.reason));
  decision_ = decision;
  if (!in_charge) return;
  cmd_vel_arbitrated_.publish(to_msg(decision.command));
  published_ = node_.steady_now();
}

void ArbitrationNode::watch() {
  if (node_.clock_silence() > kClockSilence) {
    node_.log().warn_every(1.0, "/clock is silent: stopping");
    cmd_vel_arbitrated_.publish(to_msg(Twist2{}));
    return;
  }
  const Source in_charge = arbiter_.decide(node_.now()).source;
  const bool just_stopped = in_charge == Source::kNone && decision_.source != Source::kNone;
  if (just_stopped || node_.steady_now() - published_ >= kRepeat) decide(in_charge);
}

void ArbitrationNode::publish_status() {
  tandem_msgs::msg::ArbitrationStatus msg;
  msg.header(header(node_.stamp(), ""));
  msg.policy(name(arbiter_.policy()));
  msg.source(name(decision_.source));
  msg.alpha(decision_.alpha);
  msg.reason(name(decision_.reason));
  msg.emergency_stop(arbiter_.emergency_stopped());
  msg.deadman(decision_.reason != ArbitrationReason::kUserSilent);
  msg.command(to_msg(decision_.command));
  msg.silent_sources(arbiter_.silent_sources(node_.now()));
  status_.publish(msg);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::ArbitrationNode, "arbitration")
