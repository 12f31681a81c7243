// SPDX-License-Identifier: Apache-2.0
// Overrides a topic's QoS by parameters with rclcpp's names. Private to runtime/.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "tandem/runtime/parameter_table.hpp"
#include "tandem/runtime/parameters.hpp"
#include "tandem/runtime/qos.hpp"

namespace tandem::runtime {

/// "qos_overrides./odom.subscription", whose parameters are the policies.
[[nodiscard]] std::string qos_prefix(const std::string& topic, const std::string& kind);

/// qos_overrides.<topic>.<publisher|subscription>.{reliability, durability, depth} of a node.
class QosOverrides {
 public:
  QosOverrides(ParameterStore& store, ParameterTable& parameters)
      : store_{store}, parameters_{parameters} {}

  /// `qos` with what is given for the topic (full name) laid over it; what is given becomes
  /// parameters. Holds for every endpoint of its kind, but for the durability of one that a node
  /// opens besides, to hear latched and volatile senders alike. Throws std::invalid_argument for a
  /// value that is none.
  [[nodiscard]] QoS apply(const QoS& qos, const std::string& topic, const std::string& kind);

 private:
  ParameterStore& store_;
  ParameterTable& parameters_;
  struct Applied;
  std::map<std::string, std::shared_ptr<const Applied>> applied_;  // by prefix
};

}  // namespace tandem::runtime
