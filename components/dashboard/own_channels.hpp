// SPDX-License-Identifier: Apache-2.0
// Channels that the dashboard itself provides, beside the topics of the domain.
#pragma once

#include <cstdint>
#include <string>

#include "tandem/dashboard/web/foxglove_protocol.hpp"

namespace tandem {

inline constexpr std::uint32_t kSeatChannel = 1, kTrialChannel = 2;

/// The driver as seen by the receiving client; `node` is the dashboard's full name.
[[nodiscard]] inline foxglove::Channel driver_channel(const std::string& node) {
  constexpr const char* kSchema =
      R"({"type":"object","properties":{"driver":{"type":"string"},"clients":{"type":"integer"}}})";
  return {kSeatChannel, node + "/seat", "json", "tandem.Seat", kSchema, "jsonschema"};
}

/// The trial in progress, or the result of the last one.
[[nodiscard]] inline foxglove::Channel trial_channel(const std::string& node) {
  constexpr const char* kSchema =
      R"({"type":"object","properties":{"id":{"type":"integer"},"time":{"type":"number"},"collisions":{"type":"integer"},"trial":{"type":"object"}}})";
  return {kTrialChannel, node + "/trial", "json", "tandem.Trial", kSchema, "jsonschema"};
}

}  // namespace tandem
