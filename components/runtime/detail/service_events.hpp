// SPDX-License-Identifier: Apache-2.0
// Service introspection: publishes which requests and responses a node's services and clients send
// and receive, as rcl does for `ros2 service echo` and `ros2 action echo`. Private to runtime/.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/detail/ports.hpp"
#include "tandem/runtime/every_node.hpp"

namespace tandem::runtime {

class NodeCore;

/// What is published of each request and response.
enum class Introspection {
  kDisabled,  ///< nothing
  kMetadata,  ///< time, client and number
  kContents,  ///< also the request or response itself
};

/// What a service or client did, with the numbers of service_msgs/msg/ServiceEventInfo.
enum class ServiceEvent : std::uint8_t {
  kRequestSent = 0,
  kRequestReceived = 1,
  kResponseSent = 2,
  kResponseReceived = 3,
};

/// Publishes the events of one service or client on "<service>/_service_event". The topic is open
/// only while introspection is enabled. Use on the node's thread.
class ServiceEvents {
 public:
  /// `service`: full name; `type`: "std_srvs/srv/Trigger".
  ServiceEvents(NodeCore& node, std::string service, std::string type);

  /// Throws std::runtime_error, and changes nothing, if the topic cannot be opened.
  void configure(Introspection wanted);
  void close();

  /// Whether publish() needs the request or response.
  [[nodiscard]] bool has_contents() const { return state_ == Introspection::kContents; }
  [[nodiscard]] bool is_enabled() const { return state_ != Introspection::kDisabled; }
  /// Does nothing while disabled. `client`: the client's id, `number`: of its request, `contents`:
  /// serialized request or response.
  void publish(ServiceEvent event, const PublisherId& client, std::int64_t number,
               const std::vector<std::uint8_t>& contents);

 private:
  NodeCore& node_;
  std::string service_, type_;
  Introspection state_ = Introspection::kDisabled;
  std::shared_ptr<PublisherPort> publisher_;
};

/// The services and clients of a node whose events may be published.
class ServiceIntrospection {
 public:
  enum class Side { kServer, kClient };

  explicit ServiceIntrospection(NodeCore& node) : node_{node} {}

  /// Enables what the parameters say. Throws std::invalid_argument, and changes nothing, if a topic
  /// cannot be opened.
  void configure(const every_node::Params& params);

  /// The events of a service that the node serves or calls; `request_type`: the type of its
  /// requests. Throws std::runtime_error if introspection is enabled and the topic cannot be
  /// opened.
  [[nodiscard]] std::shared_ptr<ServiceEvents> open(const std::string& service,
                                                    const std::string& request_type, Side side);

 private:
  // Of services, clients, servers of actions, clients of actions.
  using States = std::array<Introspection, 4>;
  struct Entry {
    std::size_t kind;  // index of its state
    std::weak_ptr<ServiceEvents> events;
  };
  static States states_of(const every_node::Params& params);
  void configure_all(const States& states);

  NodeCore& node_;
  States states_{};
  std::vector<Entry> entries_;
};

}  // namespace tandem::runtime
