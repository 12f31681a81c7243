// SPDX-License-Identifier: Apache-2.0
// Overrides a topic's QoS with parameters named as in rclcpp. Private to runtime/.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "tandem/runtime/parameter_table.hpp"
#include "tandem/runtime/parameters.hpp"
#include "tandem/runtime/qos.hpp"

namespace tandem::runtime {

/// The prefix of the policy parameters, such as "qos_overrides./odom.subscription".
[[nodiscard]] std::string qos_prefix(const std::string& topic, const std::string& kind);

/// A node's parameters qos_overrides.<topic>.<publisher|subscription>.{reliability, durability,
/// depth, history}.
class QosOverrides {
 public:
  QosOverrides(ParameterStore& store, ParameterTable& parameters)
      : store_{store}, parameters_{parameters} {}

  /// Returns `qos` with the overrides given for `topic` (full name); the first call declares the
  /// parameters. What differs from the QoS of the first endpoint applies to every endpoint of the
  /// topic and kind; a value that repeats it, as one from `ros2 param dump` does, changes nothing,
  /// so that a node can still open endpoints that differ from each other. Exception: the durability
  /// override is skipped for an additional endpoint whose durability differs from the first one's,
  /// so that a node can receive from latched and volatile publishers. Throws std::invalid_argument
  /// for an invalid value.
  [[nodiscard]] QoS apply(const QoS& qos, const std::string& topic, const std::string& kind);

  /// qos_prefix() of a topic for which apply() was called; empty for others.
  [[nodiscard]] std::string prefix_of(const std::string& topic, const std::string& kind) const;

 private:
  [[nodiscard]] QoS declare(const QoS& qos, const std::string& prefix);

  ParameterStore& store_;
  ParameterTable& parameters_;
  struct Applied;
  std::map<std::string, std::shared_ptr<const Applied>> applied_;  // key: prefix
};

}  // namespace tandem::runtime
