// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/local_node.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "tandem/runtime/detail/local_endpoints.hpp"
#include "tandem/runtime/detail/local_services.hpp"

namespace tandem::runtime {
namespace {

using Rank = EventQueue::Rank;

constexpr std::int64_t kEpoch = 1'000'000'000'000'000'000;  // [ns] system time at the bus's start
constexpr double kForever = std::numeric_limits<double>::infinity();

// Does the work of a Worker as an event, so that it does not run inside wake().
class LocalWorker final : public WorkerPort, public std::enable_shared_from_this<LocalWorker> {
 public:
  LocalWorker(LocalExchange& exchange, const std::string& node, Worker::Work work,
              Worker::Done done)
      : events_{exchange.events()},
        busy_{exchange.busy(node)},
        work_{std::move(work)},
        done_{std::move(done)} {}

  void wake() override {
    if (closed_ || std::exchange(is_woken_, true)) return;
    events_.post([self = shared_from_this()] { self->run(); });
  }
  void close() override { closed_ = true; }

 private:
  void run() {
    if (closed_) return;
    is_woken_ = false;
    ++runs_;
    const double start = steady_seconds();
    const auto pause = work_();
    if (done_ && !closed_) done_();
    busy_ += steady_seconds() - start;
    if (!pause) return;
    if (*pause <= 0.0) return wake();
    events_.post_at(events_.now() + *pause, Rank::kTimer,
                    [self = shared_from_this(), runs = runs_] {
                      if (self->runs_ == runs) self->wake();
                    });
  }

  EventQueue& events_;
  double& busy_;  // [s]
  Worker::Work work_;
  Worker::Done done_;
  long runs_ = 0;
  bool is_woken_ = false;
  bool closed_ = false;
};

}  // namespace

// A timer on the bus's time.
class LocalNode::TimerEvent final : public Event {
 public:
  TimerEvent(std::weak_ptr<LocalNode> node, std::shared_ptr<TimerState> timer)
      : node_{std::move(node)}, timer_{std::move(timer)} {}
  void run() override {
    const auto node = node_.lock();
    if (!node || node->stopped() || timer_->closed || node->is_on_clock(*timer_)) return;
    node->fire(timer_);
    node->schedule(timer_);
  }

 private:
  std::weak_ptr<LocalNode> node_;
  std::shared_ptr<TimerState> timer_;
};

// The timers on /clock.
class LocalNode::ClockEvent final : public Event {
 public:
  explicit ClockEvent(std::weak_ptr<LocalNode> node) : node_{std::move(node)} {}
  void run() override {
    if (const auto node = node_.lock()) node->fire_all();
  }

 private:
  std::weak_ptr<LocalNode> node_;
};

LocalNode::LocalNode(NodeOptions node_options)
    : NodeCore{std::move(node_options)},
      bus_{options.bus},
      exchange_{bus_->exchange()},
      busy_{exchange_.busy(full_name)} {
  log.set_clock([this] { return steady_now(); });
}

std::shared_ptr<PublisherPort> LocalNode::open_publisher(const std::string& topic, TypeRef type,
                                                         const QoS& qos) {
  auto writer = std::make_shared<LocalWriter>(*this, topic, type, qos);
  exchange_.open(writer);
  return writer;
}

std::shared_ptr<PublisherPort> LocalNode::open_generic_publisher(const std::string& topic,
                                                                 const std::string& type,
                                                                 const QoS& qos,
                                                                 const std::string&) {
  auto writer = std::make_shared<LocalWriter>(*this, topic, type, qos);
  exchange_.open(writer);
  return writer;
}

std::shared_ptr<SubscriptionPort> LocalNode::open_subscription(const std::string& topic,
                                                               const QoS& qos, Receiver receiver,
                                                               Accepts accepts) {
  auto reader = std::make_shared<LocalReader>(*this, topic, qos, std::move(receiver), accepts);
  exchange_.open(reader);
  return reader;
}

std::shared_ptr<SubscriptionPort> LocalNode::open_generic_subscription(
    const std::string& topic, const std::string& type, const QoS& qos,
    std::function<void(const std::vector<std::uint8_t>&)> fn) {
  auto reader = std::make_shared<LocalReader>(*this, topic, type, qos, std::move(fn));
  exchange_.open(reader);
  return reader;
}

std::shared_ptr<ServicePort> LocalNode::open_service(const std::string& service,
                                                     Responder responder, const QoS&,
                                                     std::shared_ptr<ServiceEvents> events) {
  auto server =
      std::make_shared<LocalServer>(*this, service, std::move(responder), std::move(events));
  exchange_.open(server);
  return server;
}

std::shared_ptr<ClientPort> LocalNode::open_client(const std::string& service, TypeRef request,
                                                   TypeRef, std::shared_ptr<ServiceEvents> events) {
  return std::make_shared<LocalClient>(*this, service, request, std::move(events));
}

std::shared_ptr<ClientPort> LocalNode::open_generic_client(const std::string& service,
                                                           const std::string& type,
                                                           std::shared_ptr<ServiceEvents> events) {
  return std::make_shared<LocalClient>(*this, service, type + "_Request", std::move(events));
}

std::shared_ptr<WorkerPort> LocalNode::open_worker(Worker::Work work, Worker::Done done) {
  return std::make_shared<LocalWorker>(exchange_, full_name, std::move(work), std::move(done));
}

std::shared_ptr<void> LocalNode::watch_publishers(const std::string& topic, TypeRef type,
                                                  PublishersChanged fn) {
  return exchange_.watch_publishers(topic, type.name, std::move(fn));
}

bool LocalNode::is_present(const PublisherId& publisher) const {
  return exchange_.is_present(publisher);
}

std::size_t LocalNode::count_publishers(const std::string& topic) const {
  return exchange_.count_publishers(topic);
}

std::vector<TopicInfo> LocalNode::topics() const { return exchange_.topics(); }

std::vector<ServiceInfo> LocalNode::services() const { return exchange_.services(); }

std::int64_t LocalNode::system_nanoseconds() const {
  return kEpoch + std::llround(1e9 * steady_now());
}

void LocalNode::add(std::shared_ptr<TimerState> timer) {
  schedule(timers_.emplace_back(std::move(timer)));
}

void LocalNode::remove(TimerState& timer) {
  timer.closed = true;
  std::erase_if(timers_, [&](const auto& other) { return other.get() == &timer; });
}

void LocalNode::schedule(const std::shared_ptr<TimerState>& timer) {
  if (!timer->closed && !is_on_clock(*timer))
    exchange_.events().post_at(timer->beat.next(), Rank::kTimer,
                               std::make_shared<TimerEvent>(weak_from_this(), timer));
}

void LocalNode::fire(const std::shared_ptr<TimerState>& timer) {
  if (timer->closed || stopped()) return;
  if (!timer->beat.due(timer->wall ? steady_now() : now())) return;
  const Running running{*this};
  timer->fn();
}

void LocalNode::open_clock(const std::string& topic, const QoS& qos) {
  using rosgraph_msgs::msg::Clock;
  clock_subscription_ =
      open_subscription(topic, qos, make_receiver<Clock>([this](const Clock& message) {
                          const std::int64_t time = to_nanoseconds(message.clock());
                          set_clock(time, steady_now(), time < clock());
                        }),
                        Accepts::kCompatible);
}

void LocalNode::close_clock() {
  if (clock_subscription_) clock_subscription_->close();
  clock_subscription_.reset();
}

// After all messages of this instant, so that the timers see those that were published with the
// clock.
void LocalNode::on_clock() {
  if (!use_sim_time) {
    for (const auto& timer : timers_)
      if (!timer->wall) schedule(timer);
    return;
  }
  if (std::exchange(clock_event_posted_, true)) return;
  exchange_.events().post_at(steady_now(), Rank::kTimer,
                             std::make_shared<ClockEvent>(weak_from_this()));
}

void LocalNode::fire_all() {
  clock_event_posted_ = false;
  for (const auto& timer : std::vector(timers_))  // a copy, because a callback may add to the list
    if (is_on_clock(*timer)) fire(timer);
}

void LocalNode::spin() {
  store.check_unknown();
  while (!stopped() && exchange_.events().run_next(kForever)) {
  }
}

// Runs the bus until a callback of this node has run.
void LocalNode::spin_some(double max_wait) {
  const double end = steady_now() + max_wait;
  const long before = callbacks_;
  while (!stopped() && callbacks_ == before && exchange_.events().run_next(end)) {
  }
}

}  // namespace tandem::runtime
