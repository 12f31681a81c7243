// SPDX-License-Identifier: Apache-2.0
// In: messages, requests and time. Out: callbacks, one at a time, on the node's own thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <msgs.hpp>

#include "runtime/log.hpp"
#include "runtime/parameters.hpp"
#include "runtime/pubsub.hpp"
#include "runtime/qos.hpp"
#include "runtime/service.hpp"
#include "runtime/time.hpp"
#include "runtime/timer.hpp"

namespace tandem {
namespace runtime {

class NodeCore;

struct NodeOptions {
  std::string name;
  std::string ns = "/";
  std::map<std::string, std::string> remappings{};  ///< from → to, ROS 2 names
  ParameterSources parameters{};
  bool use_sim_time = false;  ///< a parameter `use_sim_time` wins
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

  template <class M, class Fn>
  [[nodiscard]] Subscription create_subscription(const Topic<M>& topic, Fn fn) {
    return make_subscription(topic.name, topic.qos, make_receiver<M>(std::move(fn)));
  }
  template <class M, class Fn>
  [[nodiscard]] Subscription create_subscription(const Topic<M>& topic, const QoS& qos, Fn fn) {
    return make_subscription(topic.name, qos, make_receiver<M>(std::move(fn)));
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

  /// Fires every `period` [s] on the node's clock; beats that were missed are skipped.
  [[nodiscard]] Timer create_timer(double period, std::function<void()> fn);
  /// Fires every `period` [s] of steady time, also while /clock stands.
  [[nodiscard]] Timer create_wall_timer(double period, std::function<void()> fn);

  /// Loads the given values over `defaults`. Throws std::invalid_argument in one clear line.
  template <class P>
  [[nodiscard]] Parameters<P> declare_parameters(P defaults = {}) {
    defaults.visit(store());
    return Parameters<P>{std::move(defaults)};
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

 private:
  [[nodiscard]] AnyPublisher make_publisher(const char* topic, TypeRef type, const QoS& qos);
  [[nodiscard]] Subscription make_subscription(const char* topic, const QoS& qos,
                                               Receiver receiver);
  [[nodiscard]] Service make_service(const char* service, Responder responder);
  [[nodiscard]] AnyClient make_client(const char* service, TypeRef request, TypeRef response);
  [[nodiscard]] ParameterStore& store();

  std::shared_ptr<NodeCore> core_;
};

}  // namespace runtime

namespace rt = runtime;

}  // namespace tandem
