// SPDX-License-Identifier: Apache-2.0
// In: sensing_status. Out: why octomap_local must not be driven by.
#pragma once

#include <string>

#include "tandem/io/map_input.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Subscribes what the octomap_builder says of its sensors, for a node whose `map_source` is local
/// or both. Where no node publishes it, octomap_local is of another source and is believed as long
/// as it is fresh (MapInput).
class SensingInput {
 public:
  SensingInput(rt::Node& node, const MapInputParams& params);
  SensingInput(const SensingInput&) = delete;
  SensingInput& operator=(const SensingInput&) = delete;

  /// Why the robot must stand, in one line; empty if the sensors see, or nobody tells. Silence of
  /// longer than `local_timeout` of a node that publishes is a reason too.
  [[nodiscard]] std::string trouble();

 private:
  rt::Node& node_;
  double timeout_;  // [s]
  Stamped<std::string> reason_;
  rt::Subscription subscription_;  // empty with a static map
};

}  // namespace tandem
