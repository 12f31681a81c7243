// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/node.hpp"

#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/local_bus.hpp"

namespace tandem::runtime {

using Side = ServiceIntrospection::Side;

Node::Node(NodeOptions options) : core_{NodeCore::create(std::move(options))} {}
Node::~Node() = default;

Timer Node::create_timer(double period, std::function<void()> fn) {
  auto timer = std::make_shared<TimerState>(TimerState{{now(), period}, std::move(fn), false});
  core_->add(timer);
  return {core_, timer};
}

Timer Node::create_wall_timer(double period, std::function<void()> fn) {
  auto timer =
      std::make_shared<TimerState>(TimerState{{steady_now(), period}, std::move(fn), true});
  core_->add(timer);
  return {core_, timer};
}

Worker Node::create_worker(Worker::Work work, Worker::Done done) {
  return Worker{core_->open_worker(std::move(work), std::move(done))};
}

AnyPublisher Node::make_publisher(const char* topic, TypeRef type, const QoS& qos) {
  const std::string name = core_->resolve(topic);
  const QoS wanted = core_->qos_overrides.apply(qos, name, "publisher");
  return {core_, core_->open_publisher(name, type, wanted)};
}

Subscription Node::make_subscription(const char* topic, const QoS& qos, Receiver receiver,
                                     Accepts accepts) {
  const std::string name = core_->resolve(topic);
  const QoS wanted = core_->qos_overrides.apply(qos, name, "subscription");
  return {core_, core_->open_subscription(name, wanted, std::move(receiver), accepts)};
}

GenericPublisher Node::create_generic_publisher(const std::string& topic, const std::string& type,
                                                const QoS& qos, const std::string& type_hash) {
  return GenericPublisher{AnyPublisher{
      core_, core_->open_generic_publisher(core_->resolve(topic.c_str()), type, qos, type_hash)}};
}

Subscription Node::create_generic_subscription(
    const std::string& topic, const std::string& type, const QoS& qos,
    std::function<void(const std::vector<std::uint8_t>&)> fn) {
  const std::string name = core_->resolve(topic.c_str());
  return {core_, core_->open_generic_subscription(name, type, qos, std::move(fn))};
}

bool Node::is_present(const PublisherId& publisher) const { return core_->is_present(publisher); }

std::string Node::resolve(const char* topic) const { return core_->resolve(topic); }

std::size_t Node::count_publishers(const std::string& topic) const {
  return core_->count_publishers(resolve(topic.c_str()));
}

std::vector<TopicInfo> Node::topics() const { return core_->topics(); }

std::shared_ptr<void> Node::watch_publishers(const char* topic, TypeRef type,
                                             PublishersChanged fn) {
  return core_->watch_publishers(core_->resolve(topic), type, std::move(fn));
}

Service Node::make_service(const char* service, Responder responder) {
  const std::string name = core_->resolve(service);
  auto events = core_->introspection.open(name, responder.request.type.name, Side::kServer);
  return {core_, core_->open_service(name, std::move(responder), kRequestQueue, std::move(events))};
}

AnyClient Node::make_client(const char* service, TypeRef request, TypeRef response) {
  const std::string name = core_->resolve(service);
  auto events = core_->introspection.open(name, request.name, Side::kClient);
  return {core_, core_->open_client(name, request, response, std::move(events))};
}

GenericClient Node::create_generic_client(const std::string& service, const std::string& type) {
  const std::string name = core_->resolve(service.c_str());
  auto events = core_->introspection.open(name, type + "_Request", Side::kClient);
  return GenericClient{AnyClient{core_, core_->open_generic_client(name, type, std::move(events))}};
}

std::vector<ServiceInfo> Node::services() const { return core_->services(); }

std::shared_ptr<ResultCache> Node::result_cache() const {
  return core_->options.bus ? core_->options.bus->cache() : nullptr;
}

ParameterStore& Node::store() { return core_->store; }
void Node::declare(ParameterGroup group) { core_->parameters.declare(std::move(group)); }
void Node::check_parameters() const { core_->store.check_unknown(); }

double Node::now() const { return core_->now(); }
double Node::steady_now() const { return core_->steady_now(); }
std::int64_t Node::system_nanoseconds() const { return core_->system_nanoseconds(); }
bool Node::clock_is_silent() const { return core_->clock_is_silent(); }
bool Node::use_sim_time() const { return core_->use_sim_time; }
void Node::fix_common_parameters() {
  every_node::Params params;
  for (const auto& name : names_of(params)) core_->parameters.make_read_only(name);
}
std::shared_ptr<void> Node::on_time_jump(std::function<void()> fn) {
  return core_->on_time_jump(std::move(fn));
}
builtin_interfaces::msg::Time Node::stamp() const { return core_->stamp(); }

Logger& Node::log() const { return core_->log; }
const std::string& Node::name() const { return core_->name.name; }
const std::string& Node::fully_qualified_name() const { return core_->full_name; }

void Node::spin() { core_->spin(); }
void Node::spin_some(double max_wait) { core_->spin_some(max_wait); }
void Node::stop() { core_->stop(); }
bool Node::stopped() const { return core_->stopped(); }

}  // namespace tandem::runtime
