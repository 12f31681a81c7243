// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/bridge/service_relay.hpp"

#include <algorithm>
#include <memory>
#include <ros2_schema.hpp>
#include <utility>

#include "tandem/runtime/names.hpp"

namespace tandem {
namespace {

constexpr std::uint32_t kOwn = 1;
constexpr const char* kTrigger = "std_srvs/srv/Trigger";

foxglove::Service describe(std::uint32_t id, const std::string& name, const std::string& type) {
  return {id, name, type, rt::ros2msg(type + "_Request").value_or(""),
          rt::ros2msg(type + "_Response").value_or("")};
}

bool is_offered(const rt::ServiceInfo& service) {
  return rt::is_full_name(service.name) && rt::ros2msg(service.type + "_Request") &&
         !service.type.starts_with("composition_interfaces/");
}

}  // namespace

ServiceRelay::ServiceRelay(rt::Node& node, WebServer& web, const std::string& own,
                           std::function<std_srvs::srv::Trigger::Response(ClientId)> on_own)
    : node_{node}, web_{web}, on_own_{std::move(on_own)} {
  relayed_[own].service = describe(kOwn, own, kTrigger);
}

void ServiceRelay::look(const std::set<ClientId>& clients) {
  std::set<std::string> here;
  std::vector<foxglove::Service> come;
  for (const auto& service : node_.services()) {
    if (!is_offered(service)) continue;
    here.insert(service.name);
    if (relayed_.contains(service.name)) continue;
    auto& relayed = relayed_[service.name];
    relayed.service = describe(++last_id_, service.name, service.type);
    come.push_back(relayed.service);
  }
  std::vector<std::uint32_t> gone;
  std::erase_if(relayed_, [&](const auto& entry) {
    const bool is_gone = entry.second.service.id != kOwn && !here.contains(entry.first);
    if (is_gone) gone.push_back(entry.second.service.id);
    return is_gone;
  });
  if (!come.empty()) web_.send_text(clients, foxglove::advertise_services(come));
  if (!gone.empty()) web_.send_text(clients, foxglove::unadvertise_services(gone));
  if (!come.empty() || !gone.empty()) announcement_.reset();
}

void ServiceRelay::announce_all(ClientId client) {
  if (!announcement_) {
    std::vector<foxglove::Service> all;
    for (const auto& [name, relayed] : relayed_) all.push_back(relayed.service);
    announcement_ = body_of(foxglove::advertise_services(all));
  }
  web_.answer(client, {true, {}, announcement_, true});
}

const ServiceRelay::Relayed* ServiceRelay::find(std::uint32_t service) const {
  const auto found = std::find_if(relayed_.begin(), relayed_.end(), [&](const auto& entry) {
    return entry.second.service.id == service;
  });
  return found == relayed_.end() ? nullptr : &found->second;
}

ServiceRelay::Relayed* ServiceRelay::find(std::uint32_t service) {
  return const_cast<Relayed*>(std::as_const(*this).find(service));
}

std::string ServiceRelay::name(std::uint32_t service) const {
  const Relayed* relayed = find(service);
  return relayed == nullptr ? "" : relayed->service.name;
}

bool ServiceRelay::only_reads(std::uint32_t service) const {
  const Relayed* relayed = find(service);
  if (relayed == nullptr || service == kOwn) return true;
  const auto& type = relayed->service.type;
  const std::string verb = type.substr(type.rfind('/') + 1);
  return verb.starts_with("Get") || verb.starts_with("List") || verb.starts_with("Describe");
}

void ServiceRelay::call(ClientId client, const foxglove::ServiceCall& call) {
  Relayed* relayed = find(call.service);
  if (relayed == nullptr)
    fail(client, call, "there is no service " + std::to_string(call.service));
  else if (call.encoding != "cdr")
    fail(client, call, "the encoding must be cdr, not '" + call.encoding.substr(0, 40) + "'");
  else if (call.service == kOwn)
    answer(client, call, rt::encode(on_own_(client)));
  else if (waiting_[client] >= kMaxCalls)
    fail(client, call, "too many calls are waiting for an answer");
  else
    ask(client, call, *relayed);
}

void ServiceRelay::ask(ClientId client, const foxglove::ServiceCall& call, Relayed& relayed) {
  if (!relayed.opened) try {
      relayed.client = node_.create_generic_client(relayed.service.name, relayed.service.type);
      relayed.opened = true;
    } catch (const std::exception& error) {  // names and types from other software may be invalid
      return fail(client, call, error.what());
    }
  ++waiting_[client];
  web_.charge(client, kCallCost);
  const foxglove::ServiceCall head{call.service, call.call, call.encoding, {}};
  const auto done = [this, client] {
    if (const auto count = waiting_.find(client); count != waiting_.end()) --count->second;
  };
  relayed.client.call(
      call.payload,
      [this, client, head, done](const auto& bytes) {
        done();
        answer(client, head, bytes);
      },
      kTimeout,
      [this, client, head, done] {
        done();
        fail(client, head, "no answer in time");
      });
}

void ServiceRelay::answer(ClientId client, const foxglove::ServiceCall& call,
                          const std::vector<std::uint8_t>& bytes) {
  web_.answer(client, {false, foxglove::response_head(call),
                       std::make_shared<const std::vector<std::uint8_t>>(bytes)});
}

void ServiceRelay::fail(ClientId client, const foxglove::ServiceCall& call,
                        const std::string& why) {
  web_.answer(client, {true, foxglove::call_failure(call, why)});
}

}  // namespace tandem
