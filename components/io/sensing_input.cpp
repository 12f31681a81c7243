// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/sensing_input.hpp"

#include "tandem/io/topics.hpp"

namespace tandem {

SensingInput::SensingInput(rt::Node& node, const MapInputParams& params)
    : node_{node}, timeout_{params.local_timeout} {
  if (params.map_source == "static") return;
  subscription_ = node.create_subscription(topics::sensing_status, [this](const auto& msg) {
    reason_ = {msg.reason(), node_.now()};
  });
  time_jump_ = node.on_time_jump([this] { reason_.reset(); });
}

rt::Interface SensingInput::interface() {
  return {.subscribes = {{topics::sensing_status, "map_source: local or both"}}};
}

std::string SensingInput::trouble() const {
  if (reason_.fresh(node_.now(), timeout_)) return reason_.value;
  if (subscription_.matched() == 0) return {};
  return "sensing_status is silent: is octomap_builder still running?";
}

}  // namespace tandem
