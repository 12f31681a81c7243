// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/bridge/parameter_relay.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "tandem/dashboard/complaints.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem {
namespace {

using foxglove::json;
using rcl_interfaces::msg::ParameterValue;

constexpr const char* kListService = "/list_parameters";

// rcl_interfaces/msg/ParameterType
enum Type : std::uint8_t {
  kNotSet,
  kBool,
  kInteger,
  kDouble,
  kString,
  kBytes,
  kBools,
  kIntegers,
  kDoubles,
  kStrings
};

// In the form of foxglove.websocket.v1; a float without a fraction needs an explicit type.
std::optional<json> to_json(const std::string& name, const ParameterValue& value) {
  switch (static_cast<Type>(value.type())) {
    case kBool:
      return json{{"name", name}, {"value", value.bool_value()}};
    case kInteger:
      return json{{"name", name}, {"value", value.integer_value()}};
    case kDouble:
      return json{{"name", name}, {"value", value.double_value()}, {"type", "float64"}};
    case kString:
      return json{{"name", name}, {"value", value.string_value()}};
    case kBools:
      return json{{"name", name}, {"value", value.bool_array_value()}};
    case kIntegers:
      return json{{"name", name}, {"value", value.integer_array_value()}};
    case kDoubles:
      return json{{"name", name}, {"value", value.double_array_value()}, {"type", "float64_array"}};
    case kStrings:
      return json{{"name", name}, {"value", value.string_array_value()}};
    case kNotSet:
    case kBytes:
      break;
  }
  return std::nullopt;
}

std::optional<ParameterValue> from_array(const json& value, bool real) {
  const auto all = [&](auto is) { return std::all_of(value.begin(), value.end(), is); };
  ParameterValue result;
  if (!real && all([](const json& v) { return v.is_number_integer(); })) {
    result.type(kIntegers);
    result.integer_array_value(value.get<std::vector<std::int64_t>>());
  } else if (all([](const json& v) { return v.is_number(); })) {
    result.type(kDoubles);
    result.double_array_value(value.get<std::vector<double>>());
  } else if (all([](const json& v) { return v.is_string(); })) {
    result.type(kStrings);
    result.string_array_value(value.get<std::vector<std::string>>());
  } else if (all([](const json& v) { return v.is_boolean(); })) {
    result.type(kBools);
    result.bool_array_value(value.get<std::vector<bool>>());
  } else {
    return std::nullopt;
  }
  return result;
}

std::optional<ParameterValue> from_json(const foxglove::SetParameters::One& parameter) {
  const json& value = parameter.value;
  const bool real = parameter.type.starts_with("float64");
  ParameterValue result;
  if (value.is_array()) return from_array(value, real);
  if (value.is_boolean()) {
    result.type(kBool);
    result.bool_value(value.get<bool>());
  } else if (value.is_number_integer() && !real) {
    result.type(kInteger);
    result.integer_value(value.get<std::int64_t>());
  } else if (value.is_number()) {
    result.type(kDouble);
    result.double_value(value.get<double>());
  } else if (value.is_string()) {
    result.type(kString);
    result.string_value(value.get<std::string>());
  } else {
    return std::nullopt;
  }
  return result;
}

// "/a/node.name.of.it" → "/a/node", "name.of.it"
std::pair<std::string, std::string> split(const std::string& name) {
  const auto dot = name.find('.');
  if (dot == std::string::npos) return {};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

}  // namespace

class ParameterRelay::Answer {
 public:
  Answer(WebServer& web, ClientId client, std::string id)
      : web_{web}, client_{client}, id_{std::move(id)} {}
  ~Answer() {
    if (const auto text = complaints_.text(); !text.empty())
      web_.answer(client_, {true, foxglove::status(foxglove::Level::kWarning, text)});
    web_.answer(client_, {true, foxglove::parameter_values(parameters_, id_)});
  }
  Answer(const Answer&) = delete;
  Answer& operator=(const Answer&) = delete;

  void add(const std::string& name, const ParameterValue& value) {
    if (auto parameter = to_json(name, value)) parameters_.push_back(std::move(*parameter));
  }
  void complain(const std::string& what) { complaints_.add(what); }
  /// Charges the client for the work of the other node.
  void pay() { web_.charge(client_, kCallCost); }

 private:
  WebServer& web_;
  ClientId client_;
  std::string id_;
  json parameters_ = json::array();
  Complaints complaints_;
};

ParameterRelay::ParameterRelay(rt::Node& node, WebServer& web) : node_{node}, web_{web} {}

// Only for nodes that exist: a service client for a missing node would never be removed.
ParameterRelay::Clients* ParameterRelay::clients_of(const std::string& node) {
  const auto known = clients_.find(node);
  if (known != clients_.end()) return &known->second;
  if (!nodes().contains(node) || !rt::is_full_name(node)) return nullptr;
  const auto client = [&]<class S>(const char* name) {
    return node_.create_client(rt::ServiceName<S>{(node + name).c_str()});
  };
  Clients made;
  try {
    made.list = client.template operator()<rcl_interfaces::srv::ListParameters>(kListService);
    made.get = client.template operator()<rcl_interfaces::srv::GetParameters>("/get_parameters");
    made.set = client.template operator()<rcl_interfaces::srv::SetParameters>("/set_parameters");
  } catch (const std::exception& error) {  // other software may use these names with other types
    node_.log().warn_every(10.0, "cannot read the parameters of {}: {}", node, error.what());
    return nullptr;
  }
  return &(clients_[node] = std::move(made));
}

const std::set<std::string>& ParameterRelay::nodes() {
  if (nodes_) return *nodes_;
  auto& all = nodes_.emplace();
  for (const auto& service : node_.services())
    if (service.name.ends_with(kListService))
      all.insert(
          service.name.substr(0, service.name.size() - std::string_view{kListService}.size()));
  return all;
}

bool ParameterRelay::too_many(ClientId client, std::size_t names) {
  if (names <= kMaxNames) return false;
  const std::string what = std::to_string(names) + " parameters in one request; at most " +
                           std::to_string(kMaxNames) + " are answered";
  web_.answer(client, {true, foxglove::status(foxglove::Level::kError, what)});
  return true;
}

void ParameterRelay::get(ClientId client, const foxglove::GetParameters& request) {
  if (too_many(client, request.names.size())) return;
  const auto answer = std::make_shared<Answer>(web_, client, request.id);
  std::map<std::string, Names> by_node;
  for (const auto& full : request.names) {
    const auto [node, name] = split(full);
    by_node[node].push_back(name);
  }
  for (const auto& [node, names] : by_node) get(node, names, answer);
  if (!request.names.empty()) return;
  for (const auto& node : nodes()) list(node, answer);
}

void ParameterRelay::list(const std::string& node, const std::shared_ptr<Answer>& answer) {
  Clients* clients = clients_of(node);
  if (clients == nullptr) return;
  answer->pay();
  clients->list.call(
      {}, [this, node, answer](const auto& list) { get(node, list.result().names(), answer); },
      rt::Client<rcl_interfaces::srv::ListParameters>::kTimeout, [answer] {});
}

void ParameterRelay::get(const std::string& node, const Names& names,
                         const std::shared_ptr<Answer>& answer) {
  Clients* clients = clients_of(node);
  if (clients == nullptr) return;
  answer->pay();
  rcl_interfaces::srv::GetParameters_Request request;
  request.names(names);
  clients->get.call(
      request,
      [node, names, answer](const auto& got) {
        for (std::size_t i = 0; i < std::min(names.size(), got.values().size()); ++i)
          answer->add(node + "." + names[i], got.values()[i]);
      },
      rt::Client<rcl_interfaces::srv::GetParameters>::kTimeout, [answer] {});
}

void ParameterRelay::set(ClientId client, const foxglove::SetParameters& request) {
  if (too_many(client, request.all.size())) return;
  const auto answer = std::make_shared<Answer>(web_, client, request.id);
  std::map<std::string, rcl_interfaces::srv::SetParameters_Request> by_node;
  for (const auto& parameter : request.all) {
    const auto [node, name] = split(parameter.name);
    const auto value = from_json(parameter);
    if (node.empty() || !value) {
      answer->complain(parameter.name.substr(0, 100) +
                       " is not a parameter, or its value is not a parameter value");
      continue;
    }
    auto& one = by_node[node].parameters().emplace_back();
    one.name(name);
    one.value(*value);
  }
  for (const auto& [node, wanted] : by_node) set(node, wanted, answer);
}

void ParameterRelay::set(const std::string& node,
                         const rcl_interfaces::srv::SetParameters_Request& wanted,
                         const std::shared_ptr<Answer>& answer) {
  Clients* clients = clients_of(node);
  if (clients == nullptr) return answer->complain("there is no node " + node.substr(0, 100));
  Names names;
  for (const auto& one : wanted.parameters()) names.push_back(one.name());
  answer->pay();
  clients->set.call(
      wanted,
      [this, node, names, answer](const auto& done) {
        for (const auto& result : done.results())
          if (!result.successful()) answer->complain(result.reason());
        get(node, names, answer);
      },
      rt::Client<rcl_interfaces::srv::SetParameters>::kTimeout,
      [node, answer] { answer->complain(node + " does not answer"); });
}

void ParameterRelay::subscribe(ClientId client, const foxglove::SubscribeParameters& request) {
  if (too_many(client, request.names.size())) return;
  auto& wanted = wanted_[client];
  for (const auto& name : request.names)
    if (!request.wanted)
      wanted.erase(name);
    else if (wanted.size() < kMaxNames)
      wanted.insert(name);
  listen_if_wanted();
}

void ParameterRelay::forget(ClientId client) {
  wanted_.erase(client);
  listen_if_wanted();
}

// Every node of the domain publishes these events, so that N robots whose pages listened for good
// would have to match 10 N² endpoints.
void ParameterRelay::listen_if_wanted() {
  const bool is_wanted = std::any_of(wanted_.begin(), wanted_.end(),
                                     [](const auto& entry) { return !entry.second.empty(); });
  if (!is_wanted)
    events_.reset();
  else if (!events_)
    events_ = node_.create_subscription(rt::every_node::parameter_events,
                                        [this](const auto& msg) { on_event(msg); });
}

void ParameterRelay::on_event(const rcl_interfaces::msg::ParameterEvent& event) {
  for (const auto& [client, wanted] : wanted_) {
    json changed = json::array();
    for (const auto& parameter : event.changed_parameters()) {
      const std::string name = event.node() + "." + parameter.name();
      if (!wanted.contains(name)) continue;
      if (auto value = to_json(name, parameter.value())) changed.push_back(std::move(*value));
    }
    if (!changed.empty()) web_.send(client, {true, foxglove::parameter_values(changed, "")});
  }
}

}  // namespace tandem
