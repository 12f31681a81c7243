// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/node.hpp"

#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/detail/reader_set.hpp"
#include "tandem/runtime/detail/service_core.hpp"

namespace tandem::runtime {
namespace {

constexpr const char* kRequest = "_Request";  // suffix of a service's request type

}  // namespace

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
  const std::string name = core_->resolve(topic);
  const QoS wanted = core_->qos_overrides.apply(qos, name, "publisher");
  auto writer = core_->open_writer(
      {dds_topic_name(name), codec->dds_name(), wanted, {}, qos_prefix(name, "publisher")});
  return {core_, std::move(codec), std::move(writer)};
}

Subscription Node::make_subscription(const char* topic, const QoS& qos, Receiver receiver,
                                     Accepts accepts) {
  const auto codec = std::make_shared<Codec>(receiver.type);
  auto deliver = [codec, receiver = std::move(receiver)](const Bytes& bytes, const auto&) {
    if (!codec->decode(bytes, receiver.message())) {
      receiver.reset();
      return false;
    }
    receiver.deliver();
    return true;
  };
  const std::string name = core_->resolve(topic);
  const auto tuned = [&core = *core_, name](const QoS& wanted) {
    return core.qos_overrides.apply(wanted, name, "subscription");
  };
  const Endpoint endpoint{
      dds_topic_name(name), codec->dds_name(), tuned(qos), {}, qos_prefix(name, "subscription")};
  auto readers = std::make_shared<ReaderSet>(*core_, endpoint, std::move(deliver));
  if (accepts == Accepts::kEvery) readers->accept_every_publisher(tuned);
  return {core_, std::move(readers)};
}

GenericPublisher Node::create_generic_publisher(const std::string& topic, const std::string& type,
                                                const QoS& qos, const std::string& type_hash) {
  auto writer = core_->open_writer(
      {dds_topic_name(core_->resolve(topic.c_str())), dds_type(type), qos, type_hash});
  return GenericPublisher{AnyPublisher{core_, nullptr, std::move(writer)}};
}

Subscription Node::create_generic_subscription(
    const std::string& topic, const std::string& type, const QoS& qos,
    std::function<void(const std::vector<std::uint8_t>&)> fn) {
  auto deliver = [fn = std::move(fn)](const Bytes& bytes, const auto&) {
    fn(bytes);
    return true;
  };
  const Endpoint endpoint{dds_topic_name(core_->resolve(topic.c_str())), dds_type(type), qos};
  return {core_, std::make_shared<ReaderSet>(*core_, endpoint, std::move(deliver))};
}

bool Node::is_present(const PublisherId& publisher) const {
  return core_->discovery().policies(to_guid(publisher)).has_value();
}

std::string Node::resolve(const char* topic) const { return core_->resolve(topic); }

std::size_t Node::count_publishers(const std::string& topic) const {
  const std::string name = resolve(topic.c_str());
  std::size_t count = 0;
  for (const auto& info : topics()) count += info.name == name ? info.publishers.size() : 0;
  return count;
}

std::vector<TopicInfo> Node::topics() const {
  std::map<std::pair<std::string, std::string>, TopicInfo> topics;
  for (const auto& endpoint : core_->discovery().endpoints()) {
    if (!endpoint.topic.starts_with("rt/")) continue;
    auto& info = topics[{endpoint.topic, endpoint.type}];
    info.name = ros_name(endpoint.topic);
    info.type = ros_type(endpoint.type);
    (endpoint.writes ? info.publishers : info.subscriptions).push_back(endpoint.policies);
    if (endpoint.writes && info.type_hash.empty())
      info.type_hash = type_hash_in(endpoint.user_data);
  }
  std::vector<TopicInfo> all;
  for (auto& [key, info] : topics) all.push_back(std::move(info));
  return all;
}

std::shared_ptr<void> Node::watch_publishers(const char* topic, TypeRef type,
                                             PublishersChanged fn) {
  return core_->peers().watch_publishers(dds_topic_name(core_->resolve(topic)),
                                         Codec{type}.dds_name(), std::move(fn));
}

Service Node::make_service(const char* service, Responder responder) {
  return {core_, std::make_shared<Server>(*core_, core_->resolve(service), std::move(responder))};
}

AnyClient Node::make_client(const char* service, TypeRef request, TypeRef response) {
  auto request_codec = std::make_shared<Codec>(request);
  auto response_codec = std::make_shared<Codec>(response);
  auto caller = std::make_shared<Caller>(*core_, core_->resolve(service), request_codec->dds_name(),
                                         response_codec->dds_name());
  return {core_, std::move(caller), std::move(request_codec), std::move(response_codec)};
}

GenericClient Node::create_generic_client(const std::string& service, const std::string& type) {
  return GenericClient{AnyClient{
      core_, std::make_shared<Caller>(*core_, core_->resolve(service.c_str()),
                                      dds_type(type + kRequest), dds_type(type + "_Response"))}};
}

std::vector<ServiceInfo> Node::services() const {
  std::map<std::string, std::string>
      services;  // name → type; further servers of a service add nothing
  for (const auto& endpoint : core_->discovery().endpoints()) {
    const std::string type = ros_type(endpoint.type);
    if (endpoint.writes || !endpoint.topic.starts_with("rq/") || !type.ends_with(kRequest) ||
        !endpoint.topic.ends_with("Request"))
      continue;
    const std::string name = ros_name(endpoint.topic);
    services[name.substr(0, name.size() - std::string_view{"Request"}.size())] =
        type.substr(0, type.size() - std::string_view{kRequest}.size());
  }
  std::vector<ServiceInfo> all;
  for (auto& [name, type] : services) all.push_back({name, type});
  return all;
}

ParameterStore& Node::store() { return core_->store; }
void Node::declare(ParameterGroup group) { core_->parameters.declare(std::move(group)); }
void Node::check_parameters() const { core_->store.check_unknown(); }

double Node::now() const { return core_->now(); }
double Node::steady_now() const { return steady_seconds(); }
bool Node::clock_is_silent() const { return core_->clock_is_silent(); }
bool Node::use_sim_time() const { return core_->use_sim_time; }
void Node::fix_time_source() { core_->parameters.make_read_only(kUseSimTime); }
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
