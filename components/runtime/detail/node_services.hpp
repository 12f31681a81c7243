// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: the endpoints that every ROS 2 node has, so that tools may ask it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/detail/rosout.hpp"
#include "tandem/runtime/detail/service_core.hpp"

namespace tandem::runtime {

/// A node's services for parameters, logger levels and type descriptions, its writers of
/// /parameter_events and /rosout. Answers on the node's thread.
///
/// rclcpp offers the logger levels only when asked to; here every node has them, for one wants to
/// see more of a running robot just when nobody thought of it before the start.
class NodeServices {
 public:
  explicit NodeServices(NodeCore& node);
  ~NodeServices();
  NodeServices(const NodeServices&) = delete;
  NodeServices& operator=(const NodeServices&) = delete;

 private:
  template <class S, class Fn>
  void serve(const std::string& name, const QoS& qos, Fn fn);
  void serve_parameters();
  void serve_logger_levels();
  void announce(const ParameterTable::Values& declared, const ParameterTable::Values& changed);

  NodeCore& node_;
  std::optional<RosOut> rosout_;
  Codec event_codec_;
  std::shared_ptr<Writer> events_;
  std::vector<std::unique_ptr<Server>> servers_;
};

}  // namespace tandem::runtime
