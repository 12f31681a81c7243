// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/service_events.hpp"

#include <stdexcept>
#include <string_view>
#include <utility>

#include "tandem/runtime/detail/cdr_structure.hpp"
#include "tandem/runtime/detail/node_core.hpp"

namespace tandem::runtime {
namespace {

constexpr const char* kTopic = "/_service_event";
constexpr std::string_view kRequest = "_Request";

Introspection state_of(const std::string& parameter) {
  if (parameter == "contents") return Introspection::kContents;
  return parameter == "metadata" ? Introspection::kMetadata : Introspection::kDisabled;
}

// Appends a sequence of at most one structure: none if there are no bytes of it, or if its type is
// not known. Returns false for bytes that are not of that type.
bool append_sequence(const std::string& type, const std::vector<std::uint8_t>* contents,
                     std::vector<std::uint8_t>& out) {
  const CdrStructure* structure = contents != nullptr ? CdrStructure::of(type) : nullptr;
  while (out.size() % sizeof(std::uint32_t) != 0) out.push_back(0);
  out.insert(out.end(), {std::uint8_t{structure != nullptr}, 0, 0, 0});
  return structure == nullptr || structure->append(*contents, out);
}

}  // namespace

ServiceEvents::ServiceEvents(NodeCore& node, std::string service, std::string type)
    : node_{node}, service_{std::move(service)}, type_{std::move(type)} {}

void ServiceEvents::configure(Introspection wanted) {
  if (wanted == Introspection::kDisabled) {
    close();
  } else if (!publisher_) {
    publisher_ = node_.open_generic_publisher(service_ + kTopic, type_ + "_Event", kDefault, {});
  }
  state_ = wanted;
}

void ServiceEvents::close() {
  state_ = Introspection::kDisabled;
  if (!publisher_) return;
  publisher_->close();
  node_.retire(std::exchange(publisher_, nullptr));
}

// The message is put together from its parts, because a service has no C++ type for its events.
void ServiceEvents::publish(ServiceEvent event, const PublisherId& client, std::int64_t number,
                            const std::vector<std::uint8_t>& contents) {
  if (!is_enabled()) return;
  service_msgs::msg::ServiceEventInfo info;
  info.event_type(static_cast<std::uint8_t>(event));
  info.stamp(node_.stamp());
  info.client_gid(client);
  info.sequence_number(number);
  auto bytes = encode(type_ref<service_msgs::msg::ServiceEventInfo>(), &info);
  const bool is_request =
      event == ServiceEvent::kRequestSent || event == ServiceEvent::kRequestReceived;
  const auto* included = has_contents() ? &contents : nullptr;
  if (!append_sequence(type_ + "_Request", is_request ? included : nullptr, bytes)) return;
  if (!append_sequence(type_ + "_Response", is_request ? nullptr : included, bytes)) return;
  if (publisher_->publish_bytes(bytes) != 0)
    node_.log.warn_every(1.0, "{}{}: an event could not be published", service_, kTopic);
}

ServiceIntrospection::States ServiceIntrospection::states_of(const every_node::Params& params) {
  return {state_of(params.service_introspection), state_of(params.client_introspection),
          state_of(params.action_server_introspection),
          state_of(params.action_client_introspection)};
}

void ServiceIntrospection::configure(const every_node::Params& params) try {
  configure_all(states_of(params));
  states_ = states_of(params);
} catch (const std::runtime_error& error) {
  configure_all(states_);  // opens nothing: what was enabled still is
  throw std::invalid_argument(error.what());
}

std::shared_ptr<ServiceEvents> ServiceIntrospection::open(const std::string& service,
                                                          const std::string& request_type,
                                                          Side side) {
  const bool is_action = service.find("/_action/") != std::string::npos;
  const std::size_t kind = (is_action ? 2 : 0) + (side == Side::kClient ? 1 : 0);
  auto events = std::make_shared<ServiceEvents>(
      node_, service, request_type.substr(0, request_type.size() - kRequest.size()));
  events->configure(states_.at(kind));
  std::erase_if(entries_, [](const Entry& entry) { return entry.events.expired(); });
  entries_.push_back({kind, events});
  return events;
}

void ServiceIntrospection::configure_all(const States& states) {
  for (const Entry& entry : entries_)
    if (const auto events = entry.events.lock()) events->configure(states.at(entry.kind));
}

}  // namespace tandem::runtime
