// SPDX-License-Identifier: Apache-2.0
// Subscribes to sensing_status and reports why octomap_local must not be used for driving.
#pragma once

#include <memory>
#include <string>

#include "tandem/io/map_input.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Subscribes to the octomap_builder's sensor status if `map_source` is local or both. If no node
/// publishes it, octomap_local has another source and is trusted while it is fresh (MapInput).
class SensingInput {
 public:
  /// `node` must outlive this.
  SensingInput(rt::Node& node, const MapInputParams& params);
  /// The topic that it opens.
  [[nodiscard]] static rt::Interface interface();
  SensingInput(const SensingInput&) = delete;
  SensingInput& operator=(const SensingInput&) = delete;

  /// Why the robot must stop, in one line; empty if the sensors work or no node publishes their
  /// status. A publisher that is silent for longer than `local_timeout` is also a reason.
  [[nodiscard]] std::string trouble() const;

 private:
  rt::Node& node_;
  double timeout_;  // [s]
  Stamped<std::string> reason_;
  rt::Subscription subscription_;  // empty with a static map
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
