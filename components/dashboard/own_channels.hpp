// SPDX-License-Identifier: Apache-2.0
// Channels of the dashboard that are no topics of the domain.
#pragma once

#include <cstdint>
#include <string>

#include "tandem/dashboard/web/foxglove_protocol.hpp"

namespace tandem {

inline constexpr std::uint32_t kSeatChannel = 1, kTrialChannel = 2;

/// Who drives, as the client that reads it sees it; of the dashboard with that full name.
[[nodiscard]] inline foxglove::Channel seat_channel(const std::string& node) {
  constexpr const char* kSchema =
      R"({"type":"object","properties":{"driver":{"type":"string"},"clients":{"type":"integer"}}})";
  return {kSeatChannel, node + "/seat", "json", "tandem.Seat", kSchema, "jsonschema"};
}

/// The trial that goes on, or what the last one came to.
[[nodiscard]] inline foxglove::Channel trial_channel(const std::string& node) {
  constexpr const char* kSchema =
      R"({"type":"object","properties":{"id":{"type":"integer"},"time":{"type":"number"},"collisions":{"type":"integer"},"trial":{"type":"object"}}})";
  return {kTrialChannel, node + "/trial", "json", "tandem.Trial", kSchema, "jsonschema"};
}

}  // namespace tandem
