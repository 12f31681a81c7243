// SPDX-License-Identifier: Apache-2.0
// Parses the frames of web clients and builds the frames sent to them.
//
// The protocol is foxglove.websocket.v1 (https://github.com/foxglove/ws-protocol, docs/spec.md):
// JSON in text frames, and binary frames whose first byte is the opcode, numbers little-endian.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

namespace tandem::foxglove {

/// Names of the protocol, preferred first. Foxglove's SDK and its bridge since 3.0 call it
/// foxglove.sdk.v1 and accept no other name; the frames are the same.
inline const std::vector<std::string> kSubprotocols{"foxglove.websocket.v1", "foxglove.sdk.v1"};

using Bytes = std::vector<std::uint8_t>;
using nlohmann::json;

struct Subscribe {
  struct One {
    std::uint32_t subscription, channel;
  };
  std::vector<One> all;
};
struct Unsubscribe {
  std::vector<std::uint32_t> subscriptions;
};
/// Channels that the client will publish on; it chooses their ids.
struct Advertise {
  struct One {
    std::uint32_t channel;
    std::string topic, encoding, schema_name;
  };
  std::vector<One> all;
};
struct Unadvertise {
  std::vector<std::uint32_t> channels;
};
struct Message {
  std::uint32_t channel;
  Bytes payload;
};
struct ServiceCall {
  std::uint32_t service, call;
  std::string encoding;
  Bytes payload;
};
struct GetParameters {
  std::vector<std::string> names;  ///< empty: all
  std::string id;
};
struct SetParameters {
  struct One {
    std::string name;
    json value;
    std::string type;  ///< "float64", "float64_array": marks numbers without a fraction
  };
  std::vector<One> all;
  std::string id;
};
struct SubscribeParameters {
  std::vector<std::string> names;
  bool wanted;
};
/// A frame that violates the protocol, and why.
struct Malformed {
  std::string reason;
};

using Request = std::variant<Subscribe, Unsubscribe, Advertise, Unadvertise, Message, ServiceCall,
                             GetParameters, SetParameters, SubscribeParameters, Malformed>;

/// Parse a frame; never throw, for any bytes.
[[nodiscard]] Request parse_text(std::string_view frame);
[[nodiscard]] Request parse_binary(std::span<const std::uint8_t> frame);

/// Prefix of every frame with a client's message on that channel.
[[nodiscard]] std::string message_prefix(std::uint32_t channel);

struct Channel {
  std::uint32_t id;
  std::string topic, encoding, schema_name, schema, schema_encoding;
};
struct Service {
  std::uint32_t id;
  std::string name, type, request_schema, response_schema;
};
enum class Level { kInfo, kWarning, kError };

[[nodiscard]] std::string server_info(const std::string& name, const std::string& session);
[[nodiscard]] std::string status(Level level, const std::string& message);
[[nodiscard]] std::string advertise(std::span<const Channel> channels);
[[nodiscard]] std::string unadvertise(std::span<const std::uint32_t> channels);
[[nodiscard]] std::string advertise_services(std::span<const Service> services);
[[nodiscard]] std::string unadvertise_services(std::span<const std::uint32_t> services);
[[nodiscard]] std::string parameter_values(const json& parameters, const std::string& id);
[[nodiscard]] std::string call_failure(const ServiceCall& call, const std::string& message);

/// Headers of binary frames; the payload follows.
[[nodiscard]] std::string message_head(std::uint32_t subscription, std::uint64_t nanoseconds);
[[nodiscard]] std::string response_head(const ServiceCall& call);
/// A complete binary frame.
[[nodiscard]] std::string time(std::uint64_t nanoseconds);

}  // namespace tandem::foxglove
