// SPDX-License-Identifier: Apache-2.0
// The ROS 2 node: publishers, subscriptions, services, timers and parameters, with all callbacks on
// one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <msgs.hpp>

#include "tandem/runtime/action.hpp"
#include "tandem/runtime/interface.hpp"
#include "tandem/runtime/log.hpp"
#include "tandem/runtime/parameter_table.hpp"
#include "tandem/runtime/parameters.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/qos.hpp"
#include "tandem/runtime/result_cache.hpp"
#include "tandem/runtime/service.hpp"
#include "tandem/runtime/time.hpp"
#include "tandem/runtime/timer.hpp"
#include "tandem/runtime/visibility.hpp"
#include "tandem/runtime/worker.hpp"

namespace tandem {
namespace runtime {

class LocalBus;
class NodeCore;
template <class A>
struct ActionHandlers;
template <class A>
class ActionServer;
template <class A>
class ActionClient;

/// How a node is named and configured.
struct NodeOptions {
  std::string name;                                 ///< letters, digits and _, no digit first
  std::string ns = "/";                             ///< namespace
  std::map<std::string, std::string> remappings{};  ///< from → to, ROS 2 names
  ParameterSources parameters{};                    ///< from files and the command line
  bool use_sim_time = false;                        ///< overridden by a parameter `use_sim_time`
  std::optional<LogLevel> log_level{};              ///< lowest level logged; nullopt: the process's
  bool logs_to_rosout = true;                       ///< whether log lines are also published
  /// Whether it offers the services that ROS 2 tools expect of every node (parameters, logger
  /// levels, type descriptions) and logs to /rosout if `logs_to_rosout`.
  bool serves_tools = true;
  /// A bus inside the process, see local_bus.hpp; null: DDS.
  std::shared_ptr<LocalBus> bus{};
};

/// A ROS 2 node. Its callbacks run one after another on the thread that spins it. Only stop(),
/// log() and steady_now() may be called from other threads while the node spins.
class TANDEM_EXPORT Node {
 public:
  static constexpr double kClockSilence = 0.5;  ///< [s] of steady time

  /// Throws std::invalid_argument for a bad name, remapping, parameter file or environment.
  explicit Node(NodeOptions options);
  /// A node with the default options.
  explicit Node(std::string name) : Node(NodeOptions{.name = std::move(name)}) {}
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// Publishes messages of type M until the publisher is destroyed. Throws std::invalid_argument
  /// for a bad topic name.
  template <class M>
  [[nodiscard]] Publisher<M> create_publisher(const Topic<M>& topic) {
    return Publisher<M>{make_publisher(topic.name, type_ref<M>(), topic.qos)};
  }
  /// The same with another QoS.
  template <class M>
  [[nodiscard]] Publisher<M> create_publisher(const Topic<M>& topic, const QoS& qos) {
    return Publisher<M>{make_publisher(topic.name, type_ref<M>(), qos)};
  }

  /// With Accepts::kEvery, also receives from publishers that offer less than the topic's QoS, at
  /// most 0.1 s after they are discovered.
  template <class M, class Fn>
  [[nodiscard]] Subscription create_subscription(const Topic<M>& topic, Fn fn) {
    return make_subscription(topic.name, topic.qos, make_receiver<M>(std::move(fn)), topic.accepts);
  }
  template <class M, class Fn>
  [[nodiscard]] Subscription create_subscription(const Topic<M>& topic, const QoS& qos, Fn fn) {
    return make_subscription(topic.name, qos, make_receiver<M>(std::move(fn)));
  }

  /// Endpoints of a topic whose type is known only by name ("pkg/msg/Type"); bytes are plain CDR,
  /// encapsulation included. `type_hash` is needed by ROS 2 since Iron for types not in this IDL.
  [[nodiscard]] GenericPublisher create_generic_publisher(const std::string& topic,
                                                          const std::string& type, const QoS& qos,
                                                          const std::string& type_hash = {});
  /// Calls `fn` with each serialized message of a type known only by name.
  [[nodiscard]] Subscription create_generic_subscription(
      const std::string& topic, const std::string& type, const QoS& qos,
      std::function<void(const std::vector<std::uint8_t>&)> fn);
  /// ROS 2 topics discovered on the domain so far, by name and type.
  [[nodiscard]] std::vector<TopicInfo> topics() const;

  /// Whether that publisher is on the domain. One that died remains until DDS notices.
  [[nodiscard]] bool is_present(const PublisherId& publisher) const;
  /// Number of publishers of a topic on the domain, of any type, including this node's.
  [[nodiscard]] std::size_t count_publishers(const std::string& topic) const;

  /// The topic's full name "/ns/name" after remapping.
  [[nodiscard]] std::string resolve(const char* topic) const;

  /// Calls `fn` with what all publishers of that type on the topic offer, at most 0.1 s after one
  /// is discovered or has left. Destroying the result cancels the calls.
  template <class M>
  [[nodiscard]] std::shared_ptr<void> watch_publishers(const Topic<M>& topic,
                                                       PublishersChanged fn) {
    return watch_publishers(topic.name, type_ref<M>(), std::move(fn));
  }

  /// `fn(const Request&, Response&)` fills the response.
  template <class S, class Fn>
  [[nodiscard]] Service create_service(const ServiceName<S>& service, Fn fn) {
    return make_service(service.name, make_responder<S>(std::move(fn)));
  }
  /// `fn(const Request&, Reply<S>)` sends the response, now or later.
  template <class S, class Fn>
  [[nodiscard]] Service create_deferred_service(const ServiceName<S>& service, Fn fn) {
    return make_service(service.name, make_deferred_responder<S>(std::move(fn)));
  }
  /// Calls a service; see Client.
  template <class S>
  [[nodiscard]] Client<S> create_client(const ServiceName<S>& service) {
    return Client<S>{make_client(service.name, type_ref<typename S::Request>(),
                                 type_ref<typename S::Response>())};
  }

  /// A client of a service whose type is known only by name ("pkg/srv/Type").
  [[nodiscard]] GenericClient create_generic_client(const std::string& service,
                                                    const std::string& type);
  /// ROS 2 services discovered on the domain so far, by name.
  [[nodiscard]] std::vector<ServiceInfo> services() const;

  /// Serves an action; see action_server.hpp, which a caller includes. A result is returned until
  /// `result_timeout` [s] of steady time after the goal's end; negative: always.
  template <class A>
  [[nodiscard]] ActionServer<A> create_action_server(const ActionName<A>& action,
                                                     ActionHandlers<A> handlers,
                                                     double result_timeout = kResultTimeout);
  /// Sends goals to an action's server; see action_client.hpp, which a caller includes.
  template <class A>
  [[nodiscard]] ActionClient<A> create_action_client(const ActionName<A>& action);

  /// Fires every `period` [s] on the node's clock; missed ticks are skipped.
  [[nodiscard]] Timer create_timer(double period, std::function<void()> fn);
  /// Fires every `period` [s] of steady time, even while /clock is stopped.
  [[nodiscard]] Timer create_wall_timer(double period, std::function<void()> fn);

  /// Does work away from the node's callbacks; see worker.hpp. Destroy the worker before what its
  /// work uses.
  [[nodiscard]] Worker create_worker(Worker::Work work, Worker::Done done = {});

  /// On a LocalBus with a cache, what an earlier call with this key returned, of whatever node;
  /// otherwise the result of `make()`, a std::shared_ptr<T>. The key must name everything that the
  /// result depends on. Do not change a result: other nodes may use it.
  template <class T, class Make>
  [[nodiscard]] std::shared_ptr<T> cached(const std::string& key, Make make) {
    const auto cache = result_cache();
    return cache ? cache->template get<T>(key, std::move(make)) : make();
  }

  /// Loads the given values over `defaults`; they are fixed while the node runs. Throws
  /// std::invalid_argument with a one-line message.
  template <class P>
  [[nodiscard]] Parameters<P> declare_parameters(P defaults = {}) {
    auto values = load(std::move(defaults));
    declare(make_fixed_group(values));
    return Parameters<P>{std::move(values)};
  }
  /// As above, but `ros2 param set` may change the part `live(P&)` of the values. Between callbacks
  /// the complete, checked struct is passed to `on_change(const P&)` and then replaces the old one.
  /// To reject a change, `on_change` must throw std::invalid_argument and change nothing.
  template <class P, class Live>
  [[nodiscard]] Parameters<P> declare_parameters(P defaults, Live live,
                                                 std::function<void(const P&)> on_change) {
    auto values = load(std::move(defaults));
    declare(make_group<P>(values, names_of(live(*values)), std::move(on_change)));
    return Parameters<P>{std::move(values)};
  }
  /// Throws std::invalid_argument for a given key that was not declared. spin() calls it first.
  void check_parameters() const;

  [[nodiscard]] double now() const;         ///< [s] node's clock: steady, or /clock (0 before it)
  [[nodiscard]] double steady_now() const;  ///< [s]
  /// [ns] since 1970 on the system's clock, also under use_sim_time
  [[nodiscard]] std::int64_t system_nanoseconds() const;
  /// Whether the last /clock (or the node's start) is more than kClockSilence ago. now() stands
  /// still then and no message ages, so that a node that moves a robot must stop it. Always false
  /// without use_sim_time.
  [[nodiscard]] bool clock_is_silent() const;
  /// Whether the node's clock is /clock. The parameter `use_sim_time` may change while the node
  /// runs, unless fix_common_parameters() was called.
  [[nodiscard]] bool use_sim_time() const;
  /// Makes the parameters of every node read-only, for a node that must not take its time from
  /// another clock, or open topics, because somebody sets a parameter.
  void fix_common_parameters();
  /// Calls `fn` whenever /clock jumps back, or `use_sim_time` is changed, before a later message is
  /// delivered: times taken from now() earlier may then lie in the future, and their age is
  /// unknown. Destroying the result cancels the calls.
  [[nodiscard]] std::shared_ptr<void> on_time_jump(std::function<void()> fn);
  /// Timestamp for message headers: system clock, or /clock under use_sim_time.
  [[nodiscard]] builtin_interfaces::msg::Time stamp() const;

  /// The node's logger. Thread-safe.
  [[nodiscard]] Logger& log() const;
  /// The node's name, without its namespace.
  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] const std::string& fully_qualified_name() const;  ///< "/ns/name"

  /// Runs callbacks until stop().
  void spin();
  /// Runs the callbacks that are due, waiting at most `max_wait` [s] for the first.
  void spin_some(double max_wait);
  /// Makes spin() return soon. Thread-safe.
  void stop();
  /// Whether stop() was called, or the process is shutting down.
  [[nodiscard]] bool stopped() const;

  /// For the runtime itself.
  [[nodiscard]] const std::shared_ptr<NodeCore>& core() const { return core_; }

 private:
  [[nodiscard]] AnyPublisher make_publisher(const char* topic, TypeRef type, const QoS& qos);
  [[nodiscard]] Subscription make_subscription(const char* topic, const QoS& qos, Receiver receiver,
                                               Accepts accepts = Accepts::kCompatible);
  [[nodiscard]] std::shared_ptr<void> watch_publishers(const char* topic, TypeRef type,
                                                       PublishersChanged fn);
  [[nodiscard]] Service make_service(const char* service, Responder responder);
  [[nodiscard]] AnyClient make_client(const char* service, TypeRef request, TypeRef response);
  template <class P>
  [[nodiscard]] std::shared_ptr<P> load(P defaults) {
    auto values = std::make_shared<P>(std::move(defaults));
    values->visit(store());
    return values;
  }
  [[nodiscard]] std::shared_ptr<ResultCache> result_cache() const;
  [[nodiscard]] ParameterStore& store();
  void declare(ParameterGroup group);

  std::shared_ptr<NodeCore> core_;
};

}  // namespace runtime

namespace rt = runtime;

}  // namespace tandem
