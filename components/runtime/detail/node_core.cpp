// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/node_core.hpp"

#include <algorithm>
#include <utility>

#include "tandem/runtime/detail/dds_node.hpp"
#include "tandem/runtime/detail/local_node.hpp"
#include "tandem/runtime/detail/node_services.hpp"
#include "tandem/runtime/detail/running_nodes.hpp"
#include "tandem/runtime/every_node.hpp"

namespace tandem::runtime {
namespace {

// ROS 2's name for a node's logger: "ns.name".
std::string logger_name(std::string full_name) {
  std::replace(full_name.begin(), full_name.end(), '/', '.');
  return full_name.substr(1);
}

}  // namespace

std::shared_ptr<NodeCore> NodeCore::create(NodeOptions options) {
  std::shared_ptr<NodeCore> core;
  if (options.bus)
    core = std::make_shared<LocalNode>(std::move(options));
  else
    core = std::make_shared<DdsNode>(std::move(options));
  core->open();
  return core;
}

NodeCore::NodeCore(NodeOptions node_options)
    : options{std::move(node_options)},
      name{make_node_name(options.ns, options.name)},
      full_name{name.full()},
      log{logger_name(full_name)},
      store{full_name, options.parameters},
      use_sim_time{options.use_sim_time} {
  log.set_level(options.log_level);
  declare_params();
  for (const auto& [from, to] : options.remappings) (void)resolve(from.c_str());
}

NodeCore::~NodeCore() = default;

void NodeCore::open() {
  clock_arrival_ = steady_now();
  if (use_sim_time) follow_clock();
  if (options.serves_tools) services_ = std::make_unique<NodeServices>(*this);
  running_nodes::add(*this);
}

void NodeCore::close() {
  running_nodes::remove(*this);
  services_.reset();
  close_clock();
}

void NodeCore::declare_params() {
  const auto params = std::make_shared<every_node::Params>(every_node::Params{use_sim_time});
  params->visit(store);
  use_sim_time = params->use_sim_time;
  serves_type_descriptions = params->start_type_description_service;
  introspection.configure(*params);
  auto live = names_of(*params);
  live.erase(every_node::Params::kTypeDescriptionService);
  parameters.declare(
      make_group<every_node::Params>(params, live, [this](const every_node::Params& wanted) {
        introspection.configure(wanted);
        set_use_sim_time(wanted.use_sim_time);
      }));
}

// Times kept so far are of another clock, so this counts as a jump.
void NodeCore::set_use_sim_time(bool wanted) {
  if (wanted == use_sim_time) return;
  use_sim_time = wanted;
  clock_ = 0;
  clock_arrival_ = steady_now();
  if (wanted)
    follow_clock();
  else
    close_clock();
  report_time_jump(steady_now());
  on_clock();
}

void NodeCore::follow_clock() {
  const std::string topic = resolve(every_node::clock.name);
  const QoS qos = qos_overrides.apply(every_node::clock.qos, topic, "subscription");
  open_clock(topic, qos);
}

void NodeCore::set_clock(std::int64_t time, double arrival, bool jumped_back) {
  clock_ = time;
  clock_arrival_ = std::max(clock_arrival_.load(), arrival);
  if (jumped_back) report_time_jump(arrival);
  on_clock();
}

void NodeCore::report_time_jump(double arrival) {
  jumped_ = arrival;
  std::erase_if(time_jumps_, [](const auto& fn) { return fn.expired(); });
  for (const auto& weak : std::vector(time_jumps_))  // a copy, because a call may add to the list
    if (const auto fn = weak.lock()) (*fn)();
}

std::shared_ptr<void> NodeCore::on_time_jump(std::function<void()> fn) {
  auto call = std::make_shared<std::function<void()>>(std::move(fn));
  time_jumps_.push_back(call);
  return call;
}

std::string NodeCore::resolve(const char* topic) const {
  return resolve_name(topic, name, options.remappings);
}

double NodeCore::now() const {
  return use_sim_time ? 1e-9 * static_cast<double>(clock_) : steady_now() - waited_;
}

bool NodeCore::clock_is_silent() const {
  return use_sim_time && steady_now() - clock_arrival_ > Node::kClockSilence;
}

builtin_interfaces::msg::Time NodeCore::stamp() const {
  const auto waited = static_cast<std::int64_t>(1e9 * waited_);
  return to_stamp(use_sim_time ? clock_.load() : system_nanoseconds() - waited);
}

}  // namespace tandem::runtime
