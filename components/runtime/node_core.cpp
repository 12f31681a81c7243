// SPDX-License-Identifier: Apache-2.0
#include "runtime/node_core.hpp"

#include <algorithm>
#include <limits>

#include "runtime/graph.hpp"
#include "runtime/running_nodes.hpp"

namespace tandem::runtime {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

// What is in `list` now, kept alive while callbacks may shorten or lengthen the list.
template <class T>
std::vector<std::shared_ptr<T>> snapshot(const std::vector<std::shared_ptr<T>>& list) {
  return list;
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
      log{name.name},
      store{full_name, options.parameters},
      use_sim_time{options.use_sim_time},
      participant_{Participant::shared()},
      clock_arrival_{steady_seconds()} {
  store("use_sim_time", use_sim_time, "time is what /clock says");
  for (const auto& [from, to] : options.remappings) (void)resolve(from.c_str());
  participant_->graph().add_node(name);
  wait_set_.attach_condition(wake_up_);
  if (use_sim_time) follow_clock();
  running_nodes::add(*this);
}

NodeCore::~NodeCore() {
  running_nodes::remove(*this);
  if (clock_reader_) close_reader(*clock_reader_);
  wait_set_.detach_condition(wake_up_);
  participant_->graph().remove_node(name);
}

void NodeCore::follow_clock() {
  using rosgraph_msgs::msg::Clock;
  auto codec = std::make_shared<Codec>(type_ref<Clock>());
  clock_reader_ = open_reader(
      {"rt/clock", codec->dds_name(), kClock}, [this, codec](const Bytes& bytes, const auto&) {
        Clock message;
        if (!codec->decode(bytes, &message)) return false;
        clock_ = std::int64_t{message.clock().sec()} * 1'000'000'000 + message.clock().nanosec();
        clock_arrival_ = steady_seconds();
        return true;
      });
}

std::shared_ptr<Writer> NodeCore::open_writer(const Endpoint& endpoint) {
  auto writer = std::make_shared<Writer>(*participant_, endpoint);
  participant_->graph().add_writer(name, writer->guid());
  return writer;
}

std::shared_ptr<Reader> NodeCore::open_reader(const Endpoint& endpoint, Reader::Deliver deliver) {
  auto malformed = [this, topic = ros_name(endpoint.topic),
                    type = ros_type(endpoint.type)](std::size_t size) {
    log.write_every(1.0, LogLevel::kWarn, topic,
                    fmt::format("{}: dropped {} bytes that are no {}", topic, size, type));
  };
  auto reader = std::make_shared<Reader>(*participant_, endpoint, std::move(deliver), malformed);
  participant_->graph().add_reader(name, reader->guid());
  wait_set_.attach_condition(reader->condition());
  readers_.push_back(reader);
  return reader;
}

void NodeCore::close_writer(Writer& writer) { participant_->graph().remove(name, writer.guid()); }

void NodeCore::close_reader(Reader& reader) {
  reader.close();
  wait_set_.detach_condition(reader.condition());
  participant_->graph().remove(name, reader.guid());
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

double NodeCore::clock_silence() const {
  return use_sim_time ? steady_seconds() - clock_arrival_ : 0.0;
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
  int taken = 0;
  for (const auto& reader : snapshot(readers_))
    if (!stopped_) taken += reader->drain();
  return taken > 0;
}

bool NodeCore::run_timers() {
  bool fired = false;
  for (const auto& timer : snapshot(timers_)) {
    if (stopped_ || timer->closed) continue;
    if (!timer->beat.due(timer->wall ? steady_seconds() : now())) continue;
    timer->fn();
    fired = true;
  }
  return fired;
}

void NodeCore::run_pollers() {
  for (const auto& poller : snapshot(pollers_))
    if (!poller->closed) poller->next = poller->poll(steady_seconds());
}

}  // namespace tandem::runtime
