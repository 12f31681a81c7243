// SPDX-License-Identifier: Apache-2.0
// The part of a node that does not depend on its bus, shared by its handles so that they may
// outlive the Node. Private to runtime/.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/detail/ports.hpp"
#include "tandem/runtime/detail/qos_overrides.hpp"
#include "tandem/runtime/detail/service_events.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/worker.hpp"

namespace tandem::runtime {

/// QoS of the requests of a service: ROS 2's profile with a deeper queue, because an evicted
/// request is lost for good.
inline constexpr QoS kRequestQueue{.depth = 100};

/// Period, function and clock of a Timer.
struct TimerState {
  Beat beat;
  std::function<void()> fn;
  bool wall;  ///< uses steady time even under use_sim_time
  bool closed = false;
};

class NodeServices;

/// Name, parameters, log and clock of a node. A bus derives from it and provides the rest. Use on
/// the node's thread only, but for stop(), log and steady_now().
class NodeCore {
 public:
  /// A node on the bus that the options name. Throws as Node's constructor.
  [[nodiscard]] static std::shared_ptr<NodeCore> create(NodeOptions options);
  virtual ~NodeCore();
  NodeCore(const NodeCore&) = delete;
  NodeCore& operator=(const NodeCore&) = delete;

  // Names of topics and services are full ones.
  [[nodiscard]] virtual std::shared_ptr<PublisherPort> open_publisher(const std::string& topic,
                                                                      TypeRef type,
                                                                      const QoS& qos) = 0;
  [[nodiscard]] virtual std::shared_ptr<PublisherPort> open_generic_publisher(
      const std::string& topic, const std::string& type, const QoS& qos,
      const std::string& type_hash) = 0;
  [[nodiscard]] virtual std::shared_ptr<SubscriptionPort> open_subscription(
      const std::string& topic, const QoS& qos, Receiver receiver, Accepts accepts) = 0;
  [[nodiscard]] virtual std::shared_ptr<SubscriptionPort> open_generic_subscription(
      const std::string& topic, const std::string& type, const QoS& qos,
      std::function<void(const std::vector<std::uint8_t>&)> fn) = 0;
  /// `events`: of this service alone; null: none are published.
  [[nodiscard]] virtual std::shared_ptr<ServicePort> open_service(
      const std::string& service, Responder responder, const QoS& qos,
      std::shared_ptr<ServiceEvents> events) = 0;
  [[nodiscard]] virtual std::shared_ptr<ClientPort> open_client(
      const std::string& service, TypeRef request, TypeRef response,
      std::shared_ptr<ServiceEvents> events) = 0;
  [[nodiscard]] virtual std::shared_ptr<ClientPort> open_generic_client(
      const std::string& service, const std::string& type,
      std::shared_ptr<ServiceEvents> events) = 0;
  [[nodiscard]] virtual std::shared_ptr<WorkerPort> open_worker(Worker::Work work,
                                                                Worker::Done done) = 0;
  [[nodiscard]] virtual std::shared_ptr<void> watch_publishers(const std::string& topic,
                                                               TypeRef type,
                                                               PublishersChanged fn) = 0;
  virtual void add(std::shared_ptr<TimerState> timer) = 0;
  virtual void remove(TimerState& timer) = 0;
  /// See Timer::skip_until() and Timer::resume(). A bus may ignore them.
  virtual int skip_until(TimerState& timer, double time) = 0;
  virtual void resume(TimerState& timer) = 0;
  /// Keeps `part` alive until the running callbacks return: a callback may close its own caller.
  virtual void retire(std::shared_ptr<void> part) = 0;

  [[nodiscard]] virtual bool is_present(const PublisherId& publisher) const = 0;
  /// As Node::count_publishers(), for a resolved name.
  [[nodiscard]] virtual std::size_t count_publishers(const std::string& topic) const = 0;
  [[nodiscard]] virtual std::vector<TopicInfo> topics() const = 0;
  [[nodiscard]] virtual std::vector<ServiceInfo> services() const = 0;

  [[nodiscard]] virtual double steady_now() const = 0;                ///< [s]
  [[nodiscard]] virtual std::int64_t system_nanoseconds() const = 0;  ///< since 1970
  virtual void spin() = 0;
  virtual void spin_some(double max_wait) = 0;
  virtual void stop() { stopped_ = true; }

  [[nodiscard]] bool stopped() const { return stopped_; }
  [[nodiscard]] std::string resolve(const char* topic) const;
  [[nodiscard]] double now() const;
  [[nodiscard]] bool clock_is_silent() const;
  [[nodiscard]] std::shared_ptr<void> on_time_jump(std::function<void()> fn);
  [[nodiscard]] builtin_interfaces::msg::Time stamp() const;
  /// Calls `deliver` for a message that arrived `waited` [s] ago, of a subscription whose messages
  /// may wait for `patience` [s]: now() and stamp() are those of its arrival, but for simulated
  /// time, whose speed is not known. Returns the result; true, without a call, if time has jumped
  /// back since.
  template <class Deliver>
  bool at_arrival(double waited, double patience, Deliver deliver) {
    if (patience <= 0.0) return deliver();
    struct Reset {
      ~Reset() { waited = 0.0; }
      std::atomic<double>& waited;
    } const at_end{waited_};
    waited_ = std::clamp(waited, 0.0, patience);
    return steady_now() - waited_ < jumped_ || deliver();
  }

  const NodeOptions options;
  const NodeName name;
  const std::string full_name;
  Logger log;
  ParameterStore store;
  ParameterTable parameters;
  QosOverrides qos_overrides{store, parameters};
  ServiceIntrospection introspection{*this};
  bool use_sim_time;
  bool serves_type_descriptions = true;

 protected:
  explicit NodeCore(NodeOptions node_options);
  /// Opens the services and topics of every node. Called once the derived class is complete.
  void open();
  /// Closes them. To be called by the derived class's destructor.
  void close();
  /// Follows the clock topic, from the time that is known already: calls set_clock().
  virtual void open_clock(const std::string& topic, const QoS& qos) = 0;
  virtual void close_clock() = 0;
  /// Takes a time [ns] of /clock and its arrival [s] on the steady clock.
  void set_clock(std::int64_t time, double arrival, bool jumped_back);
  [[nodiscard]] std::int64_t clock() const { return clock_; }  ///< [ns]
  /// Called when /clock has been received, and when `use_sim_time` was changed.
  virtual void on_clock() {}

 private:
  void declare_params();
  void set_use_sim_time(bool wanted);
  void report_time_jump(double arrival);
  void follow_clock();

  std::vector<std::weak_ptr<std::function<void()>>> time_jumps_;  // called when the time jumps
  std::unique_ptr<NodeServices> services_;
  std::atomic<std::int64_t> clock_ = 0;      // the node's time on /clock [ns]
  std::atomic<double> clock_arrival_ = 0.0;  // its arrival, or the node's start [s], steady clock
  std::atomic<double> waited_ = 0.0;         // how long ago the message that is handled arrived [s]
  double jumped_ = 0.0;  // arrival of the last jump of the time [s], steady clock
  std::atomic<bool> stopped_ = false;
};

}  // namespace tandem::runtime
