// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/node_core.hpp"

#include <algorithm>
#include <limits>
#include <mutex>

#include "tandem/runtime/detail/graph.hpp"
#include "tandem/runtime/detail/guard_report.hpp"
#include "tandem/runtime/detail/node_services.hpp"
#include "tandem/runtime/detail/running_nodes.hpp"
#include "tandem/runtime/every_node.hpp"

namespace tandem::runtime {
namespace {

// The parameters of every node of rclcpp, besides those of its QoS.
struct CommonParams {
  bool use_sim_time;
  bool start_type_description_service = true;

  template <class Visitor>
  void visit(Visitor&& field) {
    field(kUseSimTime, use_sim_time, "true: the time is taken from /clock");
    field(kTypeDescriptionService, start_type_description_service,
          "whether the node serves ~/get_type_description");
  }
};

// Time for a peer to open a compatible endpoint [s]; under DDS Security its second participant is
// authenticated separately.
constexpr double kSettling = 1.0, kSecuredSettling = 10.0;
constexpr double kForever = std::numeric_limits<double>::infinity();

// ROS 2's name for a node's logger: "ns.name".
std::string logger_name(std::string full_name) {
  std::replace(full_name.begin(), full_name.end(), '/', '.');
  return full_name.substr(1);
}

// The due items of `list`, kept alive because callbacks may change the list. Filtering here avoids
// copying pointers to the many readers and pollers that are idle most of the time.
template <class T, class Due>
std::vector<std::shared_ptr<T>> select(const std::vector<std::shared_ptr<T>>& list, Due due) {
  std::vector<std::shared_ptr<T>> selected;
  for (const auto& item : list)
    if (due(*item)) selected.push_back(item);
  return selected;
}

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

NodeCore::NodeCore(NodeOptions node_options)
    : options{std::move(node_options)},
      name{make_node_name(options.ns, options.name)},
      full_name{name.full()},
      log{logger_name(full_name)},
      store{full_name, options.parameters},
      use_sim_time{options.use_sim_time},
      participant_{Participant::shared()},
      peers_{participant_->discovery(), log,
             participant_->security().on() ? kSecuredSettling : kSettling},
      clock_arrival_{steady_seconds()} {
  log.set_level(options.log_level);
  report_security(participant_->security());
  declare_common();
  for (const auto& [from, to] : options.remappings) (void)resolve(from.c_str());
  participant_->graph().add_node(name);
  wait_set_.attach_condition(wake_up_);
  peer_poller_->poll = [this](double steady_now) { return peers_.poll(steady_now); };
  add(peer_poller_);
  guard_report_ = std::make_unique<GuardReport>(*this);
  guard_poller_->poll = [this](double steady_now) { return guard_report_->poll(steady_now); };
  add(guard_poller_);
  if (use_sim_time) follow_clock();
  if (options.serves_tools) services_ = std::make_unique<NodeServices>(*this);
  running_nodes::add(*this);
}

NodeCore::~NodeCore() {
  running_nodes::remove(*this);
  services_.reset();
  guard_report_.reset();
  if (clock_reader_) close_reader(*clock_reader_);
  wait_set_.detach_condition(wake_up_);
  participant_->graph().remove_node(name);
}

void NodeCore::declare_common() {
  const auto params = std::make_shared<CommonParams>(CommonParams{use_sim_time});
  params->visit(store);
  use_sim_time = params->use_sim_time;
  serves_type_descriptions = params->start_type_description_service;
  parameters.declare(make_group<CommonParams>(
      params, {kUseSimTime},
      [this](const CommonParams& wanted) { set_use_sim_time(wanted.use_sim_time); }));
}

// Times kept so far are of another clock, so this counts as a jump.
void NodeCore::set_use_sim_time(bool wanted) {
  if (wanted == use_sim_time) return;
  use_sim_time = wanted;
  clock_ = 0;
  clock_arrival_ = steady_seconds();
  if (wanted) {
    follow_clock();
  } else {
    close_reader(*clock_reader_);
    clock_reader_.reset();
  }
  report_time_jump();
}

void NodeCore::follow_clock() {
  using rosgraph_msgs::msg::Clock;
  auto codec = std::make_shared<Codec>(type_ref<Clock>());
  const std::string topic = resolve(every_node::clock.name);
  clock_reader_ = open_reader({dds_topic_name(topic),
                               codec->dds_name(),
                               qos_overrides.apply(every_node::clock.qos, topic, "subscription"),
                               {},
                               qos_prefix(topic, "subscription")},
                              [this, codec](const Bytes& bytes, const auto&) {
                                Clock message;
                                if (!codec->decode(bytes, &message)) return false;
                                set_clock(message.clock());
                                return true;
                              });
}

void NodeCore::set_clock(const builtin_interfaces::msg::Time& time) {
  const std::int64_t now = std::int64_t{time.sec()} * 1'000'000'000 + time.nanosec();
  const bool jumps_back = now < clock_;
  clock_ = now;
  clock_arrival_ = steady_seconds();
  if (jumps_back) report_time_jump();
}

void NodeCore::report_time_jump() {
  std::erase_if(time_jumps_, [](const auto& fn) { return fn.expired(); });
  for (const auto& weak : std::vector(time_jumps_))  // a copy, because a call may add to the list
    if (const auto fn = weak.lock()) (*fn)();
}

std::shared_ptr<void> NodeCore::on_time_jump(std::function<void()> fn) {
  auto call = std::make_shared<std::function<void()>>(std::move(fn));
  time_jumps_.push_back(call);
  return call;
}

std::shared_ptr<Writer> NodeCore::open_writer(const Endpoint& endpoint) {
  auto writer = std::make_shared<Writer>(*participant_, endpoint);
  writer->participant().graph().add_writer(name, writer->guid());
  know(writer->guid(), endpoint, true);
  return writer;
}

std::shared_ptr<Reader> NodeCore::open_reader(const Endpoint& endpoint, Reader::Deliver deliver) {
  const auto warn = [this, topic = ros_name(endpoint.topic)](const char* kind,
                                                             const std::string& what) {
    log.write_every(1.0, LogLevel::kWarn, topic + kind, topic + ": dropped " + what);
  };
  Reader::Refused refused{
      .malformed =
          [warn, type = ros_type(endpoint.type)](std::size_t size) {
            warn("malformed", fmt::format("{} bytes that are not a valid {}", size, type));
          },
      .late =
          [warn, lifespan = endpoint.qos.lifespan] {
            warn("late", fmt::format("a message that arrived more than {} s late", lifespan));
          }};
  auto reader =
      std::make_shared<Reader>(*participant_, endpoint, std::move(deliver), std::move(refused));
  reader->participant().graph().add_reader(name, reader->guid());
  know(reader->guid(), endpoint, false);
  wait_set_.attach_condition(reader->condition());
  readers_.push_back(reader);
  return reader;
}

// DDS does not report a participant's own endpoints to it.
void NodeCore::know(const rtps::GUID_t& guid, const Endpoint& endpoint, bool writes) {
  participant_->discovery().add({.guid = guid,
                                 .writes = writes,
                                 .topic = endpoint.topic,
                                 .type = endpoint.type,
                                 .policies = policies_of(endpoint.qos),
                                 .user_data = endpoint.user_data(participant_->speaks_humble()),
                                 .since = steady_seconds()});
  peers_.add(guid, endpoint, writes);
}

void NodeCore::forget(const rtps::GUID_t& guid) {
  participant_->discovery().remove(guid);
  peers_.remove(guid);
}

void NodeCore::close_writer(Writer& writer) {
  writer.participant().graph().remove(name, writer.guid());
  forget(writer.guid());
}

void NodeCore::close_reader(Reader& reader) {
  reader.close();
  wait_set_.detach_condition(reader.condition());
  reader.participant().graph().remove(name, reader.guid());
  forget(reader.guid());
  erase(readers_, reader);
}

void NodeCore::remove(TimerState& timer) {
  timer.closed = true;
  erase(timers_, timer);
}

void NodeCore::remove(Poller& poller) {
  poller.closed = true;
  erase(pollers_, poller);
}

void NodeCore::retire(std::shared_ptr<void> part) {
  if (dispatching_) retired_.push_back(std::move(part));
}

std::string NodeCore::resolve(const char* topic) const {
  return resolve_name(topic, name, options.remappings);
}

double NodeCore::now() const {
  return use_sim_time ? 1e-9 * static_cast<double>(clock_) : steady_seconds();
}

bool NodeCore::clock_is_silent() const {
  return use_sim_time && steady_seconds() - clock_arrival_ > Node::kClockSilence;
}

builtin_interfaces::msg::Time NodeCore::stamp() const {
  return to_stamp(use_sim_time ? clock_.load() : system_nanoseconds());
}

void NodeCore::spin() {
  store.check_unknown();
  while (!stopped_) dispatch(kForever);
}

void NodeCore::spin_some(double max_wait) {
  const double end = steady_seconds() + max_wait;
  double left = max_wait;
  while (!stopped_ && !dispatch(std::max(0.0, left)) && left > 0.0) left = end - steady_seconds();
}

void NodeCore::stop() {
  stopped_ = true;
  wake_up_.set_trigger_value(true);
}

bool NodeCore::dispatch(double max_wait) {
  const double wait = time_to_next(max_wait);
  wait_set_.wait(active_, to_duration(wait));
  if (wake_up_.get_trigger_value()) wake_up_.set_trigger_value(false);
  dispatching_ = true;
  const bool received = run_readers();
  const bool fired = run_timers();
  run_pollers();
  dispatching_ = false;
  retired_.clear();
  return received || fired;
}

double NodeCore::time_to_next(double max_wait) const {
  const double now_steady = steady_seconds();
  double wait = max_wait;
  for (const auto& reader : readers_)
    if (reader->waiting()) return 0.0;
  for (const auto& timer : timers_)
    if (timer->wall || !use_sim_time) wait = std::min(wait, timer->beat.next() - now_steady);
  for (const auto& poller : pollers_) wait = std::min(wait, poller->next - now_steady);
  return std::max(0.0, wait);
}

bool NodeCore::run_readers() {
  const auto is_due = [this](Reader& reader) {
    return reader.waiting() ||
           std::find(active_.begin(), active_.end(), &reader.condition()) != active_.end();
  };
  int taken = 0;
  for (const auto& reader : select(readers_, is_due))
    if (!stopped_) taken += reader->drain();
  return taken > 0;
}

bool NodeCore::run_timers() {
  const auto all = [](const TimerState&) { return true; };
  bool fired = false;
  for (const auto& timer : select(timers_, all)) {
    if (stopped_ || timer->closed) continue;
    if (!timer->beat.due(timer->wall ? steady_seconds() : now())) continue;
    timer->fn();
    fired = true;
  }
  return fired;
}

void NodeCore::run_pollers() {
  const auto is_due = [now_steady = steady_seconds()](const Poller& poller) {
    return poller.next <= now_steady;
  };
  for (const auto& poller : select(pollers_, is_due))
    if (!poller->closed) poller->next = poller->poll(steady_seconds());
}

}  // namespace tandem::runtime
