// SPDX-License-Identifier: Apache-2.0
#include "runtime/node.hpp"

#include "runtime/node_core.hpp"
#include "runtime/service_core.hpp"

namespace tandem::runtime {

Node::Node(NodeOptions options) : core_{std::make_shared<NodeCore>(std::move(options))} {}
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

AnyPublisher Node::make_publisher(const char* topic, TypeRef type, const QoS& qos) {
  auto codec = std::make_shared<Codec>(type);
  auto writer = core_->open_writer({dds_topic_name(core_->resolve(topic)), codec->dds_name(), qos});
  return {core_, std::move(codec), std::move(writer)};
}

Subscription Node::make_subscription(const char* topic, const QoS& qos, Receiver receiver) {
  const auto codec = std::make_shared<Codec>(receiver.type);
  auto deliver = [codec, receiver = std::move(receiver)](const Bytes& bytes, const auto&) {
    if (!codec->decode(bytes, receiver.message())) {
      receiver.reset();
      return false;
    }
    receiver.deliver();
    return true;
  };
  return {core_, core_->open_reader({dds_topic_name(core_->resolve(topic)), codec->dds_name(), qos},
                                    std::move(deliver))};
}

Service Node::make_service(const char* service, Responder responder) {
  return {core_, std::make_shared<Server>(*core_, core_->resolve(service), std::move(responder))};
}

AnyClient Node::make_client(const char* service, TypeRef request, TypeRef response) {
  return {core_, std::make_shared<Caller>(*core_, core_->resolve(service), request, response)};
}

ParameterStore& Node::store() { return core_->store; }
void Node::check_parameters() const { core_->store.check_unknown(); }

double Node::now() const { return core_->now(); }
double Node::steady_now() const { return steady_seconds(); }
double Node::clock_silence() const { return core_->clock_silence(); }
bool Node::use_sim_time() const { return core_->use_sim_time; }
builtin_interfaces::msg::Time Node::stamp() const { return core_->stamp(); }

Logger& Node::log() const { return core_->log; }
const std::string& Node::name() const { return core_->name.name; }
const std::string& Node::fully_qualified_name() const { return core_->full_name; }

void Node::spin() { core_->spin(); }
void Node::spin_some(double max_wait) { core_->spin_some(max_wait); }
void Node::stop() { core_->stop(); }
bool Node::stopped() const { return core_->stopped(); }

}  // namespace tandem::runtime
