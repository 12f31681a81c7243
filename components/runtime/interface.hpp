// SPDX-License-Identifier: Apache-2.0
// Describes which topics, services and actions a component opens, for `tandem describe`,
// permissions and tests.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tandem/runtime/action.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/qos.hpp"
#include "tandem/runtime/service.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A topic that a component subscribes to or publishes. Converts from the Topic that is passed to
/// create_subscription or create_publisher, so that nothing is written twice.
struct TopicUse {
  /// `when`: condition under which the component opens it ("static_map: grid"); empty: always.
  template <class M>
  TopicUse(const Topic<M>& topic, std::string when = {})
      : TopicUse{topic.name, type_ref<M>().name, topic.qos, topic.accepts, std::move(when)} {}
  /// With another QoS than the topic's.
  template <class M>
  TopicUse(const Topic<M>& topic, const QoS& other_qos, std::string when = {})
      : TopicUse{topic.name, type_ref<M>().name, other_qos, Accepts::kCompatible, std::move(when)} {
  }
  /// Every topic of the domain.
  [[nodiscard]] static TopicUse every() { return {"*", "", kDefault, Accepts::kEvery, ""}; }

  std::string name;  ///< relative, absolute or private, as in the Topic; "*" for every topic
  std::string type;  ///< "geometry_msgs/msg/Twist"
  QoS qos;           ///< unless parameters (`qos_overrides`) change it
  Accepts accepts;   ///< kEvery: also opens weaker subscriptions for publishers that offer less
  std::string condition;  ///< when it is opened; empty: always

 private:
  TopicUse(const char* its_name, const char* its_type, const QoS& its_qos, Accepts its_accepts,
           std::string its_condition)
      : name{its_name},
        type{its_type},
        qos{its_qos},
        accepts{its_accepts},
        condition{std::move(its_condition)} {}
};

/// A service that a component serves or calls. Converts from the ServiceName that is passed to
/// create_service or create_client.
struct ServiceUse {
  /// A service with the QoS of services, or another one.
  template <class S>
  ServiceUse(const ServiceName<S>& service, const QoS& other_qos = kServices)
      : ServiceUse{service.name, S::name, other_qos} {}
  /// Every service of the domain.
  [[nodiscard]] static ServiceUse every() { return {"*", "", kServices}; }

  std::string name;         ///< as in the ServiceName; "*" for every service
  std::string type;         ///< "std_srvs/srv/Trigger"
  QoS qos;                  ///< of its requests and responses
  std::string condition{};  ///< when it is opened; empty: always

 private:
  ServiceUse(const char* its_name, const char* its_type, const QoS& its_qos)
      : name{its_name}, type{its_type}, qos{its_qos} {}
};

/// An action that a component serves or sends goals to. Converts from the ActionName that is passed
/// to create_action_server or create_action_client.
struct ActionUse {
  /// `when`: as TopicUse's.
  template <class A>
  ActionUse(const ActionName<A>& action, std::string when = {})
      : name{action.name}, type{A::name}, condition{std::move(when)} {}

  std::string name;       ///< as in the ActionName
  std::string type;       ///< "nav2_msgs/action/NavigateToPose"
  std::string condition;  ///< when it is opened; empty: always
};

/// Everything that a component exchanges with others.
struct Interface {
  std::vector<TopicUse> subscribes{}, publishes{};           ///< topics that it reads and writes
  std::vector<ServiceUse> serves{}, calls{};                 ///< services that it offers and uses
  std::vector<ActionUse> serves_actions{}, calls_actions{};  ///< actions, likewise
  std::string other_input{}, other_output{};  ///< no topics: "a map file", as text for the user
};

/// Both together, for a component that uses an input class with an interface of its own.
[[nodiscard]] TANDEM_EXPORT Interface operator+(Interface first, const Interface& second);

/// The same with a further condition on each of its topics, services and actions.
[[nodiscard]] TANDEM_EXPORT Interface only_if(const std::string& condition, Interface interface);

}  // namespace tandem::runtime
