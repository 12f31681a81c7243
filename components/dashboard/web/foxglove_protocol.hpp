// SPDX-License-Identifier: Apache-2.0
// In: frames of a web client. Out: what it asks for. And back: the frames that answer it.
//
// The protocol is foxglove.websocket.v1 (https://github.com/foxglove/ws-protocol, docs/spec.md):
// JSON in text frames, and binary frames whose first byte says what they are, numbers
// little-endian.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

namespace tandem::foxglove {

inline constexpr const char* kSubprotocol = "foxglove.websocket.v1";

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
/// Channels that the client will publish on; their numbers are the client's own.
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
  std::vector<std::string> names;  ///< none: all
  std::string id;
};
struct SetParameters {
  struct One {
    std::string name;
    json value;
    std::string type;  ///< "float64", "float64_array": for numbers without a fraction
  };
  std::vector<One> all;
  std::string id;
};
struct SubscribeParameters {
  std::vector<std::string> names;
  bool wanted;
};
/// A frame that is none of the protocol, and why.
struct Malformed {
  std::string reason;
};

using Request = std::variant<Subscribe, Unsubscribe, Advertise, Unadvertise, Message, ServiceCall,
                             GetParameters, SetParameters, SubscribeParameters, Malformed>;

/// Never throw, whatever the bytes.
[[nodiscard]] Request parse_text(std::string_view frame);
[[nodiscard]] Request parse_binary(std::span<const std::uint8_t> frame);

/// What each frame with a client's message on that channel begins with.
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

/// Heads of binary frames; the payload follows.
[[nodiscard]] std::string message_head(std::uint32_t subscription, std::uint64_t nanoseconds);
[[nodiscard]] std::string response_head(const ServiceCall& call);
/// A whole binary frame.
[[nodiscard]] std::string time(std::uint64_t nanoseconds);

}  // namespace tandem::foxglove
