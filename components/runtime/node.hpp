// SPDX-License-Identifier: Apache-2.0
// In: messages, requests and time. Out: callbacks, one at a time, on the node's own thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <msgs.hpp>

#include "tandem/runtime/log.hpp"
#include "tandem/runtime/parameter_table.hpp"
#include "tandem/runtime/parameters.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/qos.hpp"
#include "tandem/runtime/service.hpp"
#include "tandem/runtime/time.hpp"
#include "tandem/runtime/timer.hpp"

namespace tandem {
namespace runtime {

class NodeCore;

struct NodeOptions {
  std::string name;
  std::string ns = "/";
  std::map<std::string, std::string> remappings{};  ///< from → to, ROS 2 names
  ParameterSources parameters{};
  bool use_sim_time = false;            ///< a parameter `use_sim_time` wins
  std::optional<LogLevel> log_level{};  ///< least that it logs; none: the process's
  bool logs_to_rosout = true;
  /// Whether it answers what ROS 2 tools ask of every node: parameters, logger levels, types; and
  /// logs to /rosout unless logs_to_rosout forbids it.
  bool serves_tools = true;
};

/// A ROS 2 node. Its callbacks run one after another on the thread that spins it; every method but
/// stop(), log() and steady_now() belongs to that thread (or to any other while nobody spins).
class Node {
 public:
  /// Throws std::invalid_argument for a bad name, remapping, parameter file or environment.
  explicit Node(NodeOptions options);
  explicit Node(std::string name) : Node(NodeOptions{.name = std::move(name)}) {}
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  template <class M>
  [[nodiscard]] Publisher<M> create_publisher(const Topic<M>& topic) {
    return Publisher<M>{make_publisher(topic.name, type_ref<M>(), topic.qos)};
  }
  template <class M>
  [[nodiscard]] Publisher<M> create_publisher(const Topic<M>& topic, const QoS& qos) {
    return Publisher<M>{make_publisher(topic.name, type_ref<M>(), qos)};
  }

  /// Hears every publisher of a topic with Hears::kEvery: whatever offers less than the topic's QoS
  /// is heard at most 0.1 s after it is discovered.
  template <class M, class Fn>
  [[nodiscard]] Subscription create_subscription(const Topic<M>& topic, Fn fn) {
    return make_subscription(topic.name, topic.qos, make_receiver<M>(std::move(fn)), topic.hears);
  }
  template <class M, class Fn>
  [[nodiscard]] Subscription create_subscription(const Topic<M>& topic, const QoS& qos, Fn fn) {
    return make_subscription(topic.name, qos, make_receiver<M>(std::move(fn)));
  }

  /// Endpoints of a topic whose type is known by name only ("pkg/msg/Type"): bytes in plain CDR,
  /// encapsulation included. `type_hash`: for ROS 2 from Iron on, if it is no type of the IDL here.
  [[nodiscard]] GenericPublisher create_generic_publisher(const std::string& topic,
                                                          const std::string& type, const QoS& qos,
                                                          const std::string& type_hash = {});
  [[nodiscard]] Subscription create_generic_subscription(
      const std::string& topic, const std::string& type, const QoS& qos,
      std::function<void(const std::vector<std::uint8_t>&)> fn);
  /// ROS 2's topics on the domain now, as far as they are discovered; by name and type.
  [[nodiscard]] std::vector<TopicInfo> topics() const;

  /// Whether that publisher is on the domain now: one that died is until DDS notices.
  [[nodiscard]] bool is_present(const PublisherId& publisher) const;
  /// Publishers of a topic on the domain now, of whatever type, own ones included.
  [[nodiscard]] std::size_t count_publishers(const std::string& topic) const;

  /// The topic's name as it is on the domain: "/ns/name", after remapping.
  [[nodiscard]] std::string resolve(const char* topic) const;

  /// Calls `fn` once, as soon as anybody publishes messages of that type on that topic; not after
  /// the result is destroyed.
  template <class M>
  [[nodiscard]] std::shared_ptr<void> when_published(const Topic<M>& topic,
                                                     std::function<void()> fn) {
    return await_publisher(topic.name, type_ref<M>(), std::move(fn));
  }

  /// `fn(const Request&, Response&)` fills the response.
  template <class S, class Fn>
  [[nodiscard]] Service create_service(const ServiceName<S>& service, Fn fn) {
    return make_service(service.name, make_responder<S>(std::move(fn)));
  }
  template <class S>
  [[nodiscard]] Client<S> create_client(const ServiceName<S>& service) {
    return Client<S>{make_client(service.name, type_ref<typename S::Request>(),
                                 type_ref<typename S::Response>())};
  }

  /// A client of a service whose type is known by name only ("pkg/srv/Type").
  [[nodiscard]] GenericClient create_generic_client(const std::string& service,
                                                    const std::string& type);
  /// ROS 2's services on the domain now, as far as they are discovered; by name.
  [[nodiscard]] std::vector<ServiceInfo> services() const;

  /// Fires every `period` [s] on the node's clock; beats that were missed are skipped.
  [[nodiscard]] Timer create_timer(double period, std::function<void()> fn);
  /// Fires every `period` [s] of steady time, also while /clock stands.
  [[nodiscard]] Timer create_wall_timer(double period, std::function<void()> fn);

  /// Loads the given values over `defaults`; they stay what they are while the node runs. Throws
  /// std::invalid_argument in one clear line.
  template <class P>
  [[nodiscard]] Parameters<P> declare_parameters(P defaults = {}) {
    auto values = load(std::move(defaults));
    declare(make_fixed_group(values));
    return Parameters<P>{std::move(values)};
  }
  /// As above, and `ros2 param set` may change the part `live(P&)` of the values: a struct that is
  /// sound as a whole is offered to `on_change(const P&)`, between callbacks, and takes the place
  /// of the old one after it. `on_change` refuses by throwing std::invalid_argument, having changed
  /// nothing.
  template <class P, class Live>
  [[nodiscard]] Parameters<P> declare_parameters(P defaults, Live live,
                                                 std::function<void(const P&)> on_change) {
    auto values = load(std::move(defaults));
    declare(make_group<P>(values, names_of(live(*values)), std::move(on_change)));
    return Parameters<P>{std::move(values)};
  }
  /// Throws std::invalid_argument for a given key that nobody declared; spin() calls it first.
  void check_parameters() const;

  [[nodiscard]] double now() const;         ///< [s] node's clock: steady, or /clock (0 before it)
  [[nodiscard]] double steady_now() const;  ///< [s]
  /// [s] of steady time since the last /clock (or the node's start); 0 without use_sim_time.
  [[nodiscard]] double clock_silence() const;
  [[nodiscard]] bool use_sim_time() const;
  /// For message headers: system clock, or /clock under use_sim_time.
  [[nodiscard]] builtin_interfaces::msg::Time stamp() const;

  [[nodiscard]] Logger& log() const;
  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] const std::string& fully_qualified_name() const;  ///< "/ns/name"

  /// Runs callbacks until stop().
  void spin();
  /// Runs callbacks that are due, waiting at most `max_wait` [s] for the first.
  void spin_some(double max_wait);
  /// Ends spin() soon; may be called by any thread.
  void stop();
  [[nodiscard]] bool stopped() const;

  /// For the runtime itself.
  [[nodiscard]] const std::shared_ptr<NodeCore>& core() const { return core_; }

 private:
  [[nodiscard]] AnyPublisher make_publisher(const char* topic, TypeRef type, const QoS& qos);
  [[nodiscard]] Subscription make_subscription(const char* topic, const QoS& qos, Receiver receiver,
                                               Hears hears = Hears::kFitting);
  [[nodiscard]] std::shared_ptr<void> await_publisher(const char* topic, TypeRef type,
                                                      std::function<void()> fn);
  [[nodiscard]] Service make_service(const char* service, Responder responder);
  [[nodiscard]] AnyClient make_client(const char* service, TypeRef request, TypeRef response);
  template <class P>
  [[nodiscard]] std::shared_ptr<P> load(P defaults) {
    auto values = std::make_shared<P>(std::move(defaults));
    values->visit(store());
    return values;
  }
  [[nodiscard]] ParameterStore& store();
  void declare(ParameterGroup group);

  std::shared_ptr<NodeCore> core_;
};

}  // namespace runtime

namespace rt = runtime;

}  // namespace tandem
