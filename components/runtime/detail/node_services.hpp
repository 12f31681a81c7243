// SPDX-License-Identifier: Apache-2.0
// Provides the services and topics that ROS 2 tools expect of every node. Private to runtime/.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/detail/rosout.hpp"

namespace tandem::runtime {

/// A node's services for parameters, logger levels and type descriptions, and its publishers of
/// /parameter_events and /rosout. Answers on the node's thread.
///
/// Unlike in rclcpp, the logger level services are always enabled, because the need to debug a
/// running robot is rarely foreseen.
class NodeServices {
 public:
  explicit NodeServices(NodeCore& node);
  ~NodeServices();
  NodeServices(const NodeServices&) = delete;
  NodeServices& operator=(const NodeServices&) = delete;

 private:
  template <class S, class Fn>
  void serve(const ServiceName<S>& service, const QoS& qos, Fn fn);
  void serve_parameters();
  void serve_logger_levels();
  void announce_soon(const ParameterTable::Values& declared);
  void announce_declared();
  void announce(const ParameterTable::Values& declared, const ParameterTable::Values& changed);

  NodeCore& node_;
  std::optional<RosOut> rosout_;
  std::shared_ptr<PublisherPort> events_;
  ParameterTable::Values declared_;    // not announced yet
  std::shared_ptr<TimerState> timer_;  // announces them
  std::vector<std::shared_ptr<ServicePort>> servers_;
};

}  // namespace tandem::runtime
