// SPDX-License-Identifier: Apache-2.0
// A node on a LocalBus. Private to runtime/.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/detail/local_exchange.hpp"
#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {

class LocalNode final : public NodeCore, public std::enable_shared_from_this<LocalNode> {
 public:
  explicit LocalNode(NodeOptions node_options);
  ~LocalNode() override { close(); }

  [[nodiscard]] std::shared_ptr<PublisherPort> open_publisher(const std::string& topic,
                                                              TypeRef type,
                                                              const QoS& qos) override;
  [[nodiscard]] std::shared_ptr<PublisherPort> open_generic_publisher(
      const std::string& topic, const std::string& type, const QoS& qos,
      const std::string& type_hash) override;
  [[nodiscard]] std::shared_ptr<SubscriptionPort> open_subscription(const std::string& topic,
                                                                    const QoS& qos,
                                                                    Receiver receiver,
                                                                    Accepts accepts) override;
  [[nodiscard]] std::shared_ptr<SubscriptionPort> open_generic_subscription(
      const std::string& topic, const std::string& type, const QoS& qos,
      std::function<void(const std::vector<std::uint8_t>&)> fn) override;
  [[nodiscard]] std::shared_ptr<ServicePort> open_service(
      const std::string& service, Responder responder, const QoS& qos,
      std::shared_ptr<ServiceEvents> events) override;
  [[nodiscard]] std::shared_ptr<ClientPort> open_client(
      const std::string& service, TypeRef request, TypeRef response,
      std::shared_ptr<ServiceEvents> events) override;
  [[nodiscard]] std::shared_ptr<ClientPort> open_generic_client(
      const std::string& service, const std::string& type,
      std::shared_ptr<ServiceEvents> events) override;
  [[nodiscard]] std::shared_ptr<WorkerPort> open_worker(Worker::Work work,
                                                        Worker::Done done) override;
  [[nodiscard]] std::shared_ptr<void> watch_publishers(const std::string& topic, TypeRef type,
                                                       PublishersChanged fn) override;
  void add(std::shared_ptr<TimerState> timer) override;
  void remove(TimerState& timer) override;
  int skip_until(TimerState&, double) override { return 0; }  // waking costs nothing here
  void resume(TimerState&) override {}
  // An event keeps what it calls alive.
  void retire(std::shared_ptr<void>) override {}

  [[nodiscard]] bool is_present(const PublisherId& publisher) const override;
  [[nodiscard]] std::size_t count_publishers(const std::string& topic) const override;
  [[nodiscard]] std::vector<TopicInfo> topics() const override;
  [[nodiscard]] std::vector<ServiceInfo> services() const override;

  [[nodiscard]] double steady_now() const override { return exchange_.events().now(); }
  [[nodiscard]] std::int64_t system_nanoseconds() const override;
  void spin() override;
  void spin_some(double max_wait) override;

  [[nodiscard]] LocalExchange& exchange() const { return exchange_; }
  /// While it exists, a callback of the node runs.
  class Running {
   public:
    explicit Running(LocalNode& node) : busy_{node.busy_}, start_{steady_seconds()} {
      ++node.callbacks_;
    }
    ~Running() { busy_ += steady_seconds() - start_; }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

   private:
    double& busy_;  // outlives the node
    double start_;
  };

 private:
  class TimerEvent;
  class ClockEvent;
  void open_clock(const std::string& topic, const QoS& qos) override;
  void close_clock() override;
  void on_clock() override;
  [[nodiscard]] bool is_on_clock(const TimerState& timer) const {
    return use_sim_time && !timer.wall;
  }
  void schedule(const std::shared_ptr<TimerState>& timer);
  void fire(const std::shared_ptr<TimerState>& timer);
  void fire_all();

  std::shared_ptr<LocalBus> bus_;
  LocalExchange& exchange_;
  std::shared_ptr<SubscriptionPort> clock_subscription_;
  std::vector<std::shared_ptr<TimerState>> timers_;
  bool clock_event_posted_ = false;
  double& busy_;  // [s]
  long callbacks_ = 0;
};

}  // namespace tandem::runtime
