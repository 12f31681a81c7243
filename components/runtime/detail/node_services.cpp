// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/node_services.hpp"

#include <span>
#include <utility>

#include "tandem/runtime/detail/type_descriptions.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem::runtime {
namespace {

using every_node::kParameters;
using rcl_interfaces::msg::ParameterEvent;

constexpr std::size_t kMaxNames = 1000;  // per request; limits the response's size

rcl_interfaces::msg::SetLoggerLevelsResult set_level(
    Logger& log, const rcl_interfaces::msg::LoggerLevel& wanted) {
  rcl_interfaces::msg::SetLoggerLevelsResult result;
  if (wanted.name() != log.name()) {
    result.reason(fmt::format("this node's logger is {}", log.name()));
    return result;
  }
  bool known = wanted.level() == 0;  // 0 is UNSET: use the process's level
  if (known) log.set_level(std::nullopt);
  for (const auto level :
       {LogLevel::kDebug, LogLevel::kInfo, LogLevel::kWarn, LogLevel::kError, LogLevel::kOff}) {
    if (severity(level) != wanted.level()) continue;
    log.set_level(level);
    known = true;
  }
  result.successful(known);
  if (!known)
    result.reason(fmt::format("level {} is not one of 0, 10, 20, 30, 40, 50", wanted.level()));
  return result;
}

}  // namespace

NodeServices::NodeServices(NodeCore& node)
    : node_{node},
      events_{node.open_publisher(
          every_node::parameter_events.name, type_ref<ParameterEvent>(),
          node.qos_overrides.apply(every_node::parameter_events.qos,
                                   every_node::parameter_events.name, "publisher"))} {
  if (node.options.logs_to_rosout) rosout_.emplace(node);
  serve_parameters();
  serve_logger_levels();
  if (node.serves_type_descriptions)
    serve(every_node::get_type_description, kServices,
          [](const auto& asked, auto& answer) { answer = describe_type(asked); });
  node.parameters.on_event = [this](const auto& declared, const auto& changed) {
    announce_soon(declared);
    if (changed.empty()) return;
    announce_declared();
    announce({}, changed);
  };
  announce_soon(node.parameters.all());
}

NodeServices::~NodeServices() {
  if (timer_) node_.remove(*timer_);
  node_.parameters.on_event = nullptr;
  for (auto& server : servers_) server->close();
  events_->close();
}

template <class S, class Fn>
void NodeServices::serve(const ServiceName<S>& service, const QoS& qos, Fn fn) {
  servers_.push_back(node_.open_service(node_.resolve(service.name),
                                        make_responder<S>(std::move(fn)), qos, nullptr));
}

void NodeServices::serve_parameters() {
  ParameterTable& table = node_.parameters;
  serve(every_node::describe_parameters, kParameters, [&](const auto& asked, auto& answer) {
    if (asked.names().size() <= kMaxNames) answer.descriptors(table.describe(asked.names()));
  });
  serve(every_node::get_parameter_types, kParameters, [&](const auto& asked, auto& answer) {
    if (asked.names().size() <= kMaxNames) answer.types(table.types(asked.names()));
  });
  serve(every_node::get_parameters, kParameters, [&](const auto& asked, auto& answer) {
    if (asked.names().size() <= kMaxNames) answer.values(table.get(asked.names()));
  });
  serve(every_node::list_parameters, kParameters, [&](const auto& asked, auto& answer) {
    answer.result(table.list(asked.prefixes(), asked.depth()));
  });
  serve(every_node::set_parameters, kParameters, [&](const auto& asked, auto& answer) {
    if (asked.parameters().size() > kMaxNames) return;
    for (const auto& parameter : asked.parameters())
      answer.results().push_back(table.set({&parameter, 1}));
  });
  serve(every_node::set_parameters_atomically, kParameters,
        [&](const auto& asked, auto& answer) { answer.result(table.set(asked.parameters())); });
}

void NodeServices::serve_logger_levels() {
  Logger& log = node_.log;
  serve(every_node::get_logger_levels, kServices, [&](const auto& asked, auto& answer) {
    if (asked.names().size() > kMaxNames) return;
    for (const auto& name : asked.names()) {
      auto& level = answer.levels().emplace_back();
      level.name(name);
      if (name == log.name()) level.level(severity(log.level()));
    }
  });
  serve(every_node::set_logger_levels, kServices, [&](const auto& asked, auto& answer) {
    if (asked.levels().size() > kMaxNames) return;
    for (const auto& level : asked.levels()) answer.results().push_back(set_level(log, level));
  });
}

// Once the node spins, when the other nodes of its process have been made. Fast DDS 2.9.1 never
// takes a reliable sample for acknowledged if a reader of the same process joins between its
// publication and the acknowledgement of another process, and then sends a HEARTBEAT to all readers
// every 0.1 s for good.
void NodeServices::announce_soon(const ParameterTable::Values& declared) {
  constexpr double kSoon = 1e-6;  // [s]
  if (declared.empty()) return;
  declared_.insert(declared_.end(), declared.begin(), declared.end());
  if (timer_) return;
  timer_ = std::make_shared<TimerState>(
      TimerState{{node_.steady_now(), kSoon}, [this] { announce_declared(); }, true});
  node_.add(timer_);
}

void NodeServices::announce_declared() {
  if (const auto fired = std::exchange(timer_, nullptr)) node_.remove(*fired);
  if (!declared_.empty()) announce(std::exchange(declared_, {}), {});
}

void NodeServices::announce(const ParameterTable::Values& declared,
                            const ParameterTable::Values& changed) {
  ParameterEvent event;
  event.stamp(node_.stamp());
  event.node(node_.full_name);
  event.new_parameters(declared);
  event.changed_parameters(changed);
  if (events_->publish(&event) != 0)
    node_.log.warn_every(1.0, "/parameter_events: a change could not be published");
}

}  // namespace tandem::runtime
