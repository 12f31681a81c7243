// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/arbitration_node.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

// Subscriptions of e_stop: a reader receives nothing from a sender that offers a weaker QoS than it
// requests. The order matters: a program that presses once sends as soon as one reader is matched,
// and the first is matched first.
constexpr std::array<rt::QoS, 2> kStopReaders{
    {{rt::Reliability::kReliable, rt::Durability::kVolatile, ArbitrationNode::kStopDepth},
     {rt::Reliability::kBestEffort, rt::Durability::kVolatile, ArbitrationNode::kStopDepth}}};
// Another one for what a latched sender sent before it was discovered. The middleware of a volatile
// sender warns that this reader will get no messages, so it exists only beside latched senders.
constexpr rt::QoS kLatchedStop{rt::Reliability::kReliable, rt::Durability::kTransientLocal,
                               ArbitrationNode::kStopDepth};
constexpr double kLatchedStopLeft = 1.0;  // [s] for what the last of them sent

// Topic of the node whose trouble `why` repeats; null if the reason is arbitration's own.
const char* topic_behind(const std::string& why) {
  if (why.starts_with("planner: ")) return topics::planner_status.name;
  if (why.starts_with("safety filter: ")) return topics::filter_status.name;
  return why == name(ArbitrationReason::kSharedSilent) ? topics::cmd_vel_shared.name : nullptr;
}

std::string with_remedy(const std::string& why, const std::string& remedy) {
  return remedy.empty() ? why : why + " (" + remedy + ")";
}

std::string without_brackets(const std::string& text) {
  std::string rest;
  int depth = 0;
  for (const char c : text) {
    if (c == '(') ++depth;
    if (depth == 0) rest += c;
    if (c == ')') --depth;
  }
  return rest;
}

}  // namespace

rt::Interface ArbitrationNode::interface() {
  rt::Interface own{
      .subscribes = {topics::teleop_status, topics::planner_status, topics::filter_status},
      .publishes = {topics::cmd_vel_arbitrated, topics::arbitration_status},
      .serves = {services::set_policy, services::release_emergency_stop}};
  for (const rt::QoS& qos : kStopReaders) own.subscribes.emplace_back(topics::e_stop, qos);
  own.subscribes.emplace_back(topics::e_stop, kLatchedStop, "a node publishes it latched");
  return TwistInput::interface(topics::cmd_vel_user, topics::kUserInput) +
         TwistInput::interface(topics::cmd_vel_shared) +
         TwistInput::interface(topics::cmd_vel_nav, topics::kUserInput) + own +
         Causes::interface() + Diagnostics::interface();
}

ArbitrationNode::ArbitrationNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>(
          {}, [](auto& all) -> auto& { return all.arbiter.blend; },
          [this](const auto& wanted) { arbiter_.set_blend(wanted.arbiter.blend); })},
      arbiter_{params_->arbiter},
      cmd_vel_arbitrated_{node.create_publisher(topics::cmd_vel_arbitrated)},
      status_{node.create_publisher(topics::arbitration_status)},
      diagnostics_{node, {topics::cmd_vel_arbitrated.name, topics::arbitration_status.name}},
      causes_{node},
      user_{node, topics::cmd_vel_user, topics::kUserInput, params_->input,
            [this](const Twist2& twist) { on_command(twist, Source::kUser); }},
      shared_{node, topics::cmd_vel_shared, params_->input,
              [this](const Twist2& twist) { on_command(twist, Source::kShared); }},
      nav_{node, topics::cmd_vel_nav, topics::kUserInput, params_->input,
           [this](const Twist2& twist) { on_command(twist, Source::kNav); }},
      stick_{node.create_subscription(
          topics::teleop_status,
          [this](const auto& msg) { arbiter_.on_stick(msg.data(), node_.now()); })},
      planner_{node.create_subscription(
          topics::planner_status,
          [this](const auto& msg) {
            arbiter_.on_clearance(msg.clearance(), node_.now());
            arbiter_.on_planner(msg.status() < 0 ? msg.status_text() : "", node_.now());
          })},
      filter_{node.create_subscription(topics::filter_status, [this](const auto& msg) {
        const bool nothing_passes = msg.scale() == 0.0 && from_msg(msg.passed()) == Twist2{};
        arbiter_.on_filter(nothing_passes ? msg.reason() : "", node_.now());
      })} {
  for (TwistInput* input : {&user_, &shared_, &nav_}) input->set_frames(params_->frames);
  filter_.may_wait(kStatusPeriod);  // it explains a stop, and decides nothing
  // As if a sender had pressed and left; sequence numbers begin at 1.
  if (params_->start_stopped) on_stop(rt::PublisherId{}, 1, true);
  subscribe_emergency_stop();
  offer_services();
  watchdog_ = node.create_wall_timer(kWatchdog, [this] { watch(); });
  status_timer_ = node.create_wall_timer(kStatusPeriod, [this] { publish_status(); });
  time_jump_ = node.on_time_jump([this] { arbiter_.on_time_jump(node_.now()); });
}

void ArbitrationNode::on_command(const Twist2& twist, Source source) {
  const double now = node_.now();
  if (source == Source::kUser) arbiter_.on_user(twist, now);
  if (source == Source::kShared) arbiter_.on_shared(twist, now);
  if (source == Source::kNav) arbiter_.on_nav(twist, now);
  decide(source);
}

void ArbitrationNode::subscribe_emergency_stop() {
  for (std::size_t i = 0; i < stops_.size(); ++i) subscribe_stop(stops_[i], kStopReaders[i]);
  stop_publishers_ = node_.watch_publishers(topics::e_stop, [this](const auto& offered) {
    const bool latched = std::any_of(offered.begin(), offered.end(),
                                     [](const auto& sender) { return sender.durability >= 1; });
    if (latched && !latched_stop_) subscribe_stop(latched_stop_.emplace(), kLatchedStop);
    latched_left_ = {};
    if (!latched && latched_stop_)
      latched_left_ = node_.create_wall_timer(kLatchedStopLeft, [this] {
        latched_stop_.reset();
        latched_left_ = {};
      });
  });
}

void ArbitrationNode::subscribe_stop(rt::Subscription& stop, const rt::QoS& qos) {
  stop = node_.create_subscription(topics::e_stop, qos, [this, &stop](const auto& msg) {
    on_stop(stop.sender(), stop.sequence(), msg.data());
  });
}

void ArbitrationNode::on_stop(const rt::PublisherId& sender, std::uint64_t sequence, bool pressed) {
  update_stop_senders();  // first, because a `false` cancels the presses of departed senders
  if (!stop_words_.on_word(sender, sequence, pressed)) return;
  if (pressed && !arbiter_.emergency_stopped()) node_.log().warn("emergency stop");
  if (pressed) arbiter_.on_emergency_stop(true);
  arbiter_.on_emergency_stop(stop_words_.pressed());
  decide(Source::kNone);
}

void ArbitrationNode::update_stop_senders() {
  stop_words_.update_presence([this](const auto& sender) { return node_.is_present(sender); });
}

void ArbitrationNode::offer_services() {
  set_policy_ =
      node_.create_service(services::set_policy, [this](const auto& request, auto& response) {
        try {
          response.success(arbiter_.set_policy(policy_from(request.policy())));
          response.message(response.success() ? "policy is now " + request.policy()
                                              : "release the emergency stop first");
          node_.log().info("policy {}: {}", request.policy(), response.message());
        } catch (const std::invalid_argument& error) {
          response.success(false);
          response.message(error.what());
        }
      });
  release_ = node_.create_service(services::release_emergency_stop, [this](const auto&,
                                                                           auto& response) {
    response.success(arbiter_.release_emergency_stop());
    response.message(response.success() ? "released" : "a publisher of e_stop still sends true");
    node_.log().info("release of the emergency stop: {}", response.message());
  });
}

// Publishes if the source that arrived is in charge; a stop is published immediately.
void ArbitrationNode::decide(Source arrived) {
  if (stands_without_clock()) return;
  const Decision decision = arbiter_.decide(node_.now());
  const bool in_charge = decision.source == arrived || decision.source == Source::kNone ||
                         (decision.source == Source::kBlend && arrived == Source::kUser);
  decision_ = decision;
  if (decision.source != Source::kNone) watchdog_.resume();
  if (std::abs(decision.performance - performance_) > kTellPerformance) {
    performance_ = decision.performance;
    node_.log().info("performance {:.2f}, the planner's share {:.2f}", performance_,
                     decision.alpha);
  }
  if (!in_charge) return;
  cmd_vel_arbitrated_.publish(to_msg(decision.command));
  published_ = node_.steady_now();
}

bool ArbitrationNode::stands_without_clock() {
  if (!node_.clock_is_silent()) return false;
  cmd_vel_arbitrated_.publish(to_msg(Twist2{}));
  decision_ = Decision{};
  decision_.reason = ArbitrationReason::kClockSilent;
  say_why();
  return true;
}

void ArbitrationNode::watch() {
  update_stop_senders();
  if (stands_without_clock()) return;
  const Source in_charge = arbiter_.decide(node_.now()).source;
  const bool just_stopped = in_charge == Source::kNone && decision_.source != Source::kNone;
  if (just_stopped || node_.steady_now() - published_ >= kRepeat) decide(in_charge);
  say_why();
  // A robot that stands has nothing to stop. decide() takes this back when a source drives.
  if (decision_.source == Source::kNone)
    watchdog_.skip_until(published_ + kRepeat - 0.5 * kWatchdog);
}

// Reason and remedy: those of the first cause, if other nodes' troubles lead to one.
Causes::Cause ArbitrationNode::explain() {
  std::string why = arbiter_.why(decision_, node_.now());
  if (const char* topic = topic_behind(why))
    if (auto cause = causes_.behind(topic)) return *std::move(cause);
  std::string remedy = remedy_for(why);
  return {std::move(why), std::move(remedy)};
}

void ArbitrationNode::say_why() {
  const Causes::Cause cause = explain();
  const std::string& why = cause.reason;
  const bool is_own = why == name(decision_.reason);
  remedy_ = cause.remedy;
  if (decision_.source != Source::kNone && is_own)
    diagnostics_.report_well(why);
  else
    diagnostics_.report_cause(why, remedy_);
  if (std::exchange(why_, why) != why) publish_status();
  log_why(is_own);
}

// Another node's trouble is the same for all sources, also when a count in brackets changes.
void ArbitrationNode::log_why(bool is_own) {
  const std::string line = fmt::format("{}: {}", name(decision_.source), why_);
  const bool is_warning = decision_.reason == ArbitrationReason::kClockSilent;
  reasons_.enter(is_warning ? rt::LogLevel::kWarn : rt::LogLevel::kInfo,
                 is_own ? line : without_brackets(why_), with_remedy(line, remedy_));
}

void ArbitrationNode::publish_status() {
  tandem_msgs::msg::ArbitrationStatus msg;
  msg.header(header(node_.stamp(), ""));
  msg.policy(name(arbiter_.policy()));
  msg.source(name(decision_.source));
  msg.alpha(decision_.alpha);
  msg.reason(why_);
  msg.emergency_stop(arbiter_.emergency_stopped());
  msg.deadman(arbiter_.user_is_fresh(node_.now()));
  msg.command(to_msg(decision_.command));
  msg.silent_sources(arbiter_.silent_sources(node_.now()));
  msg.remedy(remedy_);
  msg.reason_code(to_msg(reason_in(why_)));
  status_.publish(msg);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::ArbitrationNode, "arbitration")
