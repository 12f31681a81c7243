// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/foxglove_protocol.hpp"

#include <optional>
#include <stdexcept>
#include <utility>

#include "tandem/config/json_text.hpp"

namespace tandem::foxglove {
namespace {

enum class ClientFrame : std::uint8_t { kMessage = 1, kServiceCall = 2 };
enum class ServerFrame : std::uint8_t { kMessage = 1, kTime = 2, kServiceResponse = 3 };

void put(std::string& frame, std::uint64_t number, int bytes) {
  for (int i = 0; i < bytes; ++i) frame.push_back(static_cast<char>(number >> (8 * i)));
}

// Reads numbers from the start of a frame.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : rest_{bytes} {}

  [[nodiscard]] std::optional<std::uint32_t> number() {
    if (rest_.size() < 4) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{rest_[i]} << (8 * i);
    rest_ = rest_.subspan(4);
    return value;
  }
  [[nodiscard]] std::optional<std::string> text(std::uint32_t size) {
    if (rest_.size() < size) return std::nullopt;
    std::string text(rest_.begin(), rest_.begin() + size);
    rest_ = rest_.subspan(size);
    return text;
  }
  [[nodiscard]] Bytes rest() const { return {rest_.begin(), rest_.end()}; }

 private:
  std::span<const std::uint8_t> rest_;
};

Request parse_message(Reader reader) {
  const auto channel = reader.number();
  if (!channel) return Malformed{"a message is shorter than its header"};
  return Message{*channel, reader.rest()};
}

Request parse_call(Reader reader) {
  const auto service = reader.number(), call = reader.number(), size = reader.number();
  auto encoding = size ? reader.text(*size) : std::nullopt;
  if (!encoding) return Malformed{"a service call is shorter than its header"};
  return ServiceCall{*service, *call, std::move(*encoding), reader.rest()};
}

// at() and get() throw if a value is missing or has another type; parse_text() catches.
std::uint32_t number(const json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffULL)
    throw std::invalid_argument("expected a 32-bit unsigned number");
  return value.get<std::uint32_t>();
}

std::vector<std::uint32_t> numbers(const json& values) {
  std::vector<std::uint32_t> all;
  for (const auto& value : values) all.push_back(number(value));
  return all;
}

std::vector<std::string> names(const json& request) {
  return request.value("parameterNames", std::vector<std::string>{});
}

Request subscribe(const json& request) {
  Subscribe result;
  for (const auto& one : request.at("subscriptions"))
    result.all.push_back({number(one.at("id")), number(one.at("channelId"))});
  return result;
}

Request client_advertise(const json& request) {
  Advertise result;
  for (const auto& one : request.at("channels"))
    result.all.push_back({number(one.at("id")), one.at("topic").get<std::string>(),
                          one.at("encoding").get<std::string>(),
                          one.at("schemaName").get<std::string>()});
  return result;
}

Request set_parameters(const json& request) {
  SetParameters result{{}, request.value("id", "")};
  for (const auto& one : request.at("parameters"))
    result.all.push_back(
        {one.at("name").get<std::string>(), one.value("value", json{}), one.value("type", "")});
  return result;
}

Request parse_request(const json& request) {
  const auto op = request.at("op").get<std::string>();
  if (op == "subscribe") return subscribe(request);
  if (op == "unsubscribe") return Unsubscribe{numbers(request.at("subscriptionIds"))};
  if (op == "advertise") return client_advertise(request);
  if (op == "unadvertise") return Unadvertise{numbers(request.at("channelIds"))};
  if (op == "getParameters") return GetParameters{names(request), request.value("id", "")};
  if (op == "setParameters") return set_parameters(request);
  if (op == "subscribeParameterUpdates") return SubscribeParameters{names(request), true};
  if (op == "unsubscribeParameterUpdates") return SubscribeParameters{names(request), false};
  return Malformed{"unknown operation '" + op.substr(0, 40) + "'"};
}

json schema_of(const std::string& type, const std::string& schema) {
  return {
      {"encoding", "cdr"}, {"schemaName", type}, {"schemaEncoding", "ros2msg"}, {"schema", schema}};
}

// Text from the domain may be invalid UTF-8.
std::string dump(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

Request parse_text(std::string_view frame) {
  try {
    return parse_request(parse_json(frame));
  } catch (const std::exception& error) {
    return Malformed{error.what()};
  }
}

Request parse_binary(std::span<const std::uint8_t> frame) {
  if (frame.empty()) return Malformed{"an empty frame"};
  const Reader rest{frame.subspan(1)};
  switch (static_cast<ClientFrame>(frame[0])) {
    case ClientFrame::kMessage:
      return parse_message(rest);
    case ClientFrame::kServiceCall:
      return parse_call(rest);
  }
  return Malformed{"unknown binary operation " + std::to_string(frame[0])};
}

std::string message_prefix(std::uint32_t channel) {
  std::string prefix;
  put(prefix, static_cast<std::uint8_t>(ClientFrame::kMessage), 1);
  put(prefix, channel, 4);
  return prefix;
}

std::string server_info(const std::string& name, const std::string& session) {
  return dump(
      {{"op", "serverInfo"},
       {"name", name},
       {"capabilities", {"clientPublish", "parameters", "parametersSubscribe", "services", "time"}},
       {"supportedEncodings", {"cdr"}},
       {"metadata", {{"ROS_DISTRO", "jazzy"}}},
       {"sessionId", session}});
}

std::string status(Level level, const std::string& message) {
  return dump({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

std::string advertise(std::span<const Channel> channels) {
  json all = json::array();
  for (const auto& c : channels)
    all.push_back({{"id", c.id},
                   {"topic", c.topic},
                   {"encoding", c.encoding},
                   {"schemaName", c.schema_name},
                   {"schema", c.schema},
                   {"schemaEncoding", c.schema_encoding}});
  return dump({{"op", "advertise"}, {"channels", std::move(all)}});
}

std::string unadvertise(std::span<const std::uint32_t> channels) {
  return dump({{"op", "unadvertise"},
               {"channelIds", std::vector<std::uint32_t>(channels.begin(), channels.end())}});
}

std::string advertise_services(std::span<const Service> services) {
  json all = json::array();
  for (const auto& s : services)
    all.push_back({{"id", s.id},
                   {"name", s.name},
                   {"type", s.type},
                   {"request", schema_of(s.type + "_Request", s.request_schema)},
                   {"response", schema_of(s.type + "_Response", s.response_schema)}});
  return dump({{"op", "advertiseServices"}, {"services", std::move(all)}});
}

std::string unadvertise_services(std::span<const std::uint32_t> services) {
  return dump({{"op", "unadvertiseServices"},
               {"serviceIds", std::vector<std::uint32_t>(services.begin(), services.end())}});
}

std::string parameter_values(const json& parameters, const std::string& id) {
  json frame{{"op", "parameterValues"}, {"parameters", parameters}};
  if (!id.empty()) frame["id"] = id;
  return dump(frame);
}

std::string call_failure(const ServiceCall& call, const std::string& message) {
  return dump({{"op", "serviceCallFailure"},
               {"serviceId", call.service},
               {"callId", call.call},
               {"message", message}});
}

std::string message_head(std::uint32_t subscription, std::uint64_t nanoseconds) {
  std::string head;
  put(head, static_cast<std::uint8_t>(ServerFrame::kMessage), 1);
  put(head, subscription, 4);
  put(head, nanoseconds, 8);
  return head;
}

std::string response_head(const ServiceCall& call) {
  std::string head;
  put(head, static_cast<std::uint8_t>(ServerFrame::kServiceResponse), 1);
  put(head, call.service, 4);
  put(head, call.call, 4);
  put(head, call.encoding.size(), 4);
  return head + call.encoding;
}

std::string time(std::uint64_t nanoseconds) {
  std::string frame;
  put(frame, static_cast<std::uint8_t>(ServerFrame::kTime), 1);
  put(frame, nanoseconds, 8);
  return frame;
}

}  // namespace tandem::foxglove
