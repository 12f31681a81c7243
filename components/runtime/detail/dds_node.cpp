// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/dds_node.hpp"

#include <algorithm>
#include <limits>
#include <mutex>

#include "tandem/runtime/detail/graph.hpp"
#include "tandem/runtime/detail/guard_report.hpp"
#include "tandem/runtime/detail/reader_set.hpp"
#include "tandem/runtime/detail/service_core.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {
namespace {

// Sends the messages of a publisher: to this process as they are, to others serialized. Without a
// codec it takes bytes only.
class DdsPublisher final : public PublisherPort {
 public:
  DdsPublisher(DdsNode& node, TypeRef type, std::shared_ptr<Codec> codec,
               std::shared_ptr<Writer> writer, std::unique_ptr<DirectWriter> direct)
      : node_{node},
        type_{type},
        codec_{std::move(codec)},
        writer_{std::move(writer)},
        direct_{std::move(direct)} {}

  std::size_t publish(const void* message) override {
    if (direct_)
      direct_->send([&] { return std::make_shared<Sample>(type_, type_.copy(message)); });
    if (is_without_readers()) return 0;
    thread_local Bytes bytes;  // reused by all publishers of this thread
    return codec_->encode(message, bytes) ? write(bytes) : bytes.size();
  }
  std::size_t publish_bytes(const Bytes& bytes) override {
    if (direct_) direct_->send([&] { return std::make_shared<Sample>(bytes); });
    return is_without_readers() ? 0 : write(bytes);
  }
  [[nodiscard]] int matched() const override { return writer_->matched(); }
  [[nodiscard]] PublisherId id() const override { return to_id(writer_->guid()); }
  [[nodiscard]] const std::string& topic() const override { return writer_->topic(); }
  void close() override {
    direct_.reset();
    node_.close_writer(*writer_);
  }

 private:
  // Whether DDS would give it to nobody, now or later.
  [[nodiscard]] bool is_without_readers() const { return direct_ && !writer_->is_read_elsewhere(); }
  [[nodiscard]] std::size_t write(const Bytes& bytes) {
    return writer_->write(bytes) ? 0 : bytes.size();
  }

  DdsNode& node_;
  TypeRef type_;
  std::shared_ptr<Codec> codec_;
  std::shared_ptr<Writer> writer_;
  std::unique_ptr<DirectWriter> direct_;  // null if it is transient local
};

// Time for a peer to open a compatible endpoint [s]; under DDS Security its second participant is
// authenticated separately.
constexpr double kSettling = 1.0, kSecuredSettling = 10.0;
constexpr const char* kRequest = "_Request";  // suffixes of a service's types
constexpr const char* kResponse = "_Response";

// Logs once per process.
void report_security(const Security& security) {
  static std::once_flag once;
  if (!security.on() && security.complaint.empty()) return;
  std::call_once(once, [&] {
    Logger log{"runtime"};
    if (security.on())
      log.info("DDS Security is on, from {}", security.folder);
    else
      log.warn(
          "ROS_SECURITY_ENABLE=true, but this process runs without security: anyone on this "
          "network can read and forge its messages: {}",
          security.complaint);
  });
}

template <class T>
void erase(std::vector<std::shared_ptr<T>>& list, const T& item) {
  std::erase_if(list, [&](const auto& element) { return element.get() == &item; });
}

}  // namespace

DdsNode::DdsNode(NodeOptions node_options)
    : NodeCore{std::move(node_options)},
      participant_{Participant::shared()},
      peers_{participant_->discovery(), log,
             participant_->security().on() ? kSecuredSettling : kSettling, wake_up_} {
  report_security(participant_->security());
  participant_->graph().add_node(name);
  guard_report_ = std::make_unique<GuardReport>(*this);
  guard_poller_->poll = [this](double steady_now) {
    if (!stopped()) participant_->publish_ends();
    return guard_report_->poll(steady_now);
  };
  guard_poller_->slack = Beat::kSlack;
  add(guard_poller_);
}

DdsNode::~DdsNode() {
  close();
  guard_report_.reset();
  participant_->graph().remove_node(name);
}

std::shared_ptr<PublisherPort> DdsNode::open_publisher(const std::string& topic, TypeRef type,
                                                       const QoS& qos) {
  auto codec = std::make_shared<Codec>(type);
  const Endpoint endpoint{dds_topic_name(topic),
                          codec->dds_name(),
                          qos,
                          {},
                          qos_overrides.prefix_of(topic, "publisher")};
  return open_publisher(endpoint, type, std::move(codec));
}

std::shared_ptr<PublisherPort> DdsNode::open_generic_publisher(const std::string& topic,
                                                               const std::string& type,
                                                               const QoS& qos,
                                                               const std::string& type_hash) {
  return open_publisher({dds_topic_name(topic), dds_type(type), qos, type_hash}, {}, nullptr);
}

std::shared_ptr<PublisherPort> DdsNode::open_publisher(const Endpoint& endpoint, TypeRef type,
                                                       std::shared_ptr<Codec> codec) {
  auto writer = open_writer(endpoint);
  std::unique_ptr<DirectWriter> direct;
  if (endpoint.qos.durability == Durability::kVolatile)
    direct =
        std::make_unique<DirectWriter>(participant_->direct_topic(endpoint.topic, endpoint.type),
                                       endpoint.qos, to_id(writer->guid()));
  return std::make_shared<DdsPublisher>(*this, type, std::move(codec), std::move(writer),
                                        std::move(direct));
}

std::shared_ptr<SubscriptionPort> DdsNode::open_subscription(const std::string& topic,
                                                             const QoS& qos, Receiver receiver,
                                                             Accepts accepts) {
  const auto codec = std::make_shared<Codec>(receiver.type);
  auto decode_and_deliver = [codec, receiver](const Bytes& bytes, const auto&) {
    if (!codec->decode(bytes, receiver.message())) {
      receiver.reset();
      return false;
    }
    receiver.deliver(receiver.message());
    return true;
  };
  auto deliver_sample = [receiver](const Sample& sample) { return deliver(sample, receiver); };
  const Endpoint endpoint{dds_topic_name(topic),
                          codec->dds_name(),
                          qos,
                          {},
                          qos_overrides.prefix_of(topic, "subscription")};
  auto readers = std::make_shared<ReaderSet>(*this, endpoint, std::move(decode_and_deliver),
                                             std::move(deliver_sample));
  if (accepts == Accepts::kEvery)
    readers->accept_every_publisher([this, topic](const QoS& wanted) {
      return qos_overrides.apply(wanted, topic, "subscription");
    });
  return readers;
}

std::shared_ptr<SubscriptionPort> DdsNode::open_generic_subscription(
    const std::string& topic, const std::string& type, const QoS& qos,
    std::function<void(const Bytes&)> fn) {
  auto deliver_bytes = [fn](const Bytes& bytes, const auto&) {
    fn(bytes);
    return true;
  };
  auto deliver_sample = [fn](const Sample& sample) {
    if (sample.bytes().empty()) return false;  // it is too large for its type
    fn(sample.bytes());
    return true;
  };
  const Endpoint endpoint{dds_topic_name(topic), dds_type(type), qos};
  return std::make_shared<ReaderSet>(*this, endpoint, std::move(deliver_bytes),
                                     std::move(deliver_sample));
}

std::shared_ptr<ServicePort> DdsNode::open_service(const std::string& service, Responder responder,
                                                   const QoS& qos,
                                                   std::shared_ptr<ServiceEvents> events) {
  return std::make_shared<Server>(*this, service, std::move(responder), qos, std::move(events));
}

std::shared_ptr<ClientPort> DdsNode::open_client(const std::string& service, TypeRef request,
                                                 TypeRef response,
                                                 std::shared_ptr<ServiceEvents> events) {
  return std::make_shared<Caller>(*this, service, request, response, std::move(events));
}

std::shared_ptr<ClientPort> DdsNode::open_generic_client(const std::string& service,
                                                         const std::string& type,
                                                         std::shared_ptr<ServiceEvents> events) {
  return std::make_shared<Caller>(*this, service, dds_type(type + kRequest),
                                  dds_type(type + kResponse), std::move(events));
}

std::shared_ptr<WorkerPort> DdsNode::open_worker(Worker::Work work, Worker::Done done) {
  auto worker = std::make_shared<ThreadWorker>(std::move(work), std::move(done), wake_up_);
  workers_.push_back(worker);
  return worker;
}

std::shared_ptr<void> DdsNode::watch_publishers(const std::string& topic, TypeRef type,
                                                PublishersChanged fn) {
  return peers_.watch_publishers(dds_topic_name(topic), Codec{type}.dds_name(), std::move(fn));
}

bool DdsNode::is_present(const PublisherId& publisher) const {
  return discovery().policies(to_guid(publisher)).has_value();
}

std::size_t DdsNode::count_publishers(const std::string& topic) const {
  const auto known = discovery().endpoints_on(dds_topic_name(topic));
  return static_cast<std::size_t>(std::count_if(
      known.begin(), known.end(), [](const auto& endpoint) { return endpoint->writes; }));
}

std::vector<TopicInfo> DdsNode::topics() const {
  std::map<std::pair<std::string, std::string>, TopicInfo> topics;
  for (const auto& known : discovery().endpoints()) {
    const KnownEndpoint& endpoint = *known;
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

std::vector<ServiceInfo> DdsNode::services() const {
  std::map<std::string, std::string>
      services;  // name → type; further servers of a service add nothing
  for (const auto& known : discovery().endpoints()) {
    const KnownEndpoint& endpoint = *known;
    const std::string type = ros_type(endpoint.type);
    if (endpoint.writes || !endpoint.topic.starts_with("rq/") || !type.ends_with(kRequest) ||
        !endpoint.topic.ends_with("Request"))
      continue;
    const std::string service = ros_name(endpoint.topic);
    services[service.substr(0, service.size() - std::string_view{"Request"}.size())] =
        type.substr(0, type.size() - std::string_view{kRequest}.size());
  }
  std::vector<ServiceInfo> all;
  for (auto& [service, type] : services) all.push_back({service, type});
  return all;
}

std::shared_ptr<Writer> DdsNode::open_writer(const Endpoint& endpoint) {
  auto writer = std::make_shared<Writer>(*participant_, endpoint);
  writer->participant().graph().add_writer(name, writer->guid());
  know(writer->guid(), endpoint, true);
  return writer;
}

std::shared_ptr<Reader> DdsNode::open_reader(const Endpoint& endpoint, Reader::Deliver deliver,
                                             Reader::DeliverSample deliver_sample) {
  const auto warn = [this, topic = ros_name(endpoint.topic)](const char* kind,
                                                             const std::string& what) {
    log.write_every(1.0, LogLevel::kWarn, topic + kind, topic + ": dropped " + what);
  };
  Reader::Refused refused{
      .malformed =
          [warn, endpoint](std::size_t size) { warn("malformed", endpoint.malformed_text(size)); },
      .late = [warn, endpoint] { warn("late", endpoint.late_text()); }};
  auto reader =
      std::make_shared<Reader>(*participant_, endpoint, std::move(deliver), std::move(refused));
  reader->participant().graph().add_reader(name, reader->guid());
  know(reader->guid(), endpoint, false);
  if (deliver_sample)
    reader->receive_directly(participant_->direct_topic(endpoint.topic, endpoint.type),
                             std::move(deliver_sample));
  reader->on_arrival([any_arrived = any_arrived_, wake_up = wake_up_, &reader = *reader] {
    any_arrived->store(true);
    if (reader.patience() <= 0.0) wake_up->notify();
  });
  readers_.push_back(reader);
  more_left_ = true;  // for what came before on_arrival()
  return reader;
}

// DDS does not report a participant's own endpoints to it.
void DdsNode::know(const rtps::GUID_t& guid, const Endpoint& endpoint, bool writes) {
  participant_->discovery().add(endpoint.known(guid, writes, *participant_));
  peers_.add(guid, endpoint, writes);
}

void DdsNode::forget(const rtps::GUID_t& guid) {
  participant_->discovery().remove(guid);
  peers_.remove(guid);
}

void DdsNode::close_writer(Writer& writer) {
  writer.participant().graph().remove(name, writer.guid());
  forget(writer.guid());
}

void DdsNode::close_reader(Reader& reader) {
  reader.close();
  reader.participant().graph().remove(name, reader.guid());
  forget(reader.guid());
  erase(readers_, reader);
  update_patience();
}

void DdsNode::update_patience() {
  patience_ = std::numeric_limits<double>::infinity();
  for (const auto& reader : readers_)
    if (const double patience = reader->patience(); patience > 0.0)
      patience_ = std::min(patience_, patience);
}

// The graph and the watch for mismatches list the process's reader as each node's own.
void DdsNode::open_clock(const std::string& topic, const QoS& qos) {
  const Endpoint endpoint{dds_topic_name(topic),
                          Codec{type_ref<rosgraph_msgs::msg::Clock>()}.dds_name(),
                          qos,
                          {},
                          qos_overrides.prefix_of(topic, "subscription")};
  clock_follower_ = std::make_unique<ClockFollower>(participant_->clock(endpoint),
                                                    [this] { wake_up_->notify(); });
  const Reader& reader = clock_follower_->reader();
  reader.participant().graph().add_reader(name, reader.guid());
  peers_.add(reader.guid(), endpoint, false);
  (void)read_clock();
}

void DdsNode::close_clock() {
  if (!clock_follower_) return;
  const Reader& reader = clock_follower_->reader();
  reader.participant().graph().remove(name, reader.guid());
  peers_.remove(reader.guid());
  clock_follower_.reset();
}

bool DdsNode::read_clock() {
  if (!clock_follower_) return false;
  const auto [time, arrival, jumped_back, refused] = clock_follower_->read();
  if (!refused.empty())
    log.write_every(1.0, LogLevel::kWarn, "refused clock",
                    fmt::format("{}: dropped {}", resolve(every_node::clock.name), refused));
  set_clock(time, arrival, jumped_back);
  return jumped_back;
}

void DdsNode::resume(TimerState& timer) { timer.beat.resume(timer.wall ? steady_now() : now()); }

void DdsNode::remove(TimerState& timer) {
  timer.closed = true;
  erase(timers_, timer);
}

void DdsNode::remove(Poller& poller) {
  poller.closed = true;
  erase(pollers_, poller);
}

void DdsNode::retire(std::shared_ptr<void> part) {
  if (dispatching_) retired_.push_back(std::move(part));
}

double DdsNode::steady_now() const { return steady_seconds(); }
std::int64_t DdsNode::system_nanoseconds() const { return runtime::system_nanoseconds(); }

}  // namespace tandem::runtime
