// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/bridge/topic_relay.hpp"

#include <algorithm>
#include <ros2_schema.hpp>
#include <utility>

#include "tandem/dashboard/complaints.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem {
namespace {

constexpr int kDepth = 10;      // queued messages per topic
constexpr int kMaxKept = 1000;  // of a latched topic: one per publisher

// A name with a part that starts with '_' is hidden.
bool is_hidden(const std::string& topic) { return topic.find("/_") != std::string::npos; }

}  // namespace

TopicRelay::TopicRelay(rt::Node& node, WebServer& web, std::vector<foxglove::Channel> own)
    : node_{node}, web_{web} {
  for (auto& channel : own) {
    last_id_ = std::max(last_id_, channel.id);
    auto& relayed = relayed_[{channel.topic, channel.schema_name}];
    relayed.channel = std::move(channel);
    relayed.listening = true;
  }
}

void TopicRelay::look(const std::set<ClientId>& clients) {
  std::set<std::pair<std::string, std::string>> here;
  std::vector<foxglove::Channel> come;
  for (const auto& topic : node_.topics()) {
    if (topic.publishers.empty() || is_hidden(topic.name)) continue;
    const auto key = here.emplace(topic.name, topic.type).first;
    if (const auto known = relayed_.find(*key); known != relayed_.end()) {
      known->second.publishers = topic.publishers;
      continue;
    }
    const auto schema = rt::ros2msg(topic.type);
    if (!schema || !rt::is_full_name(topic.name)) continue;
    auto& relayed = relayed_[*key];
    relayed.channel = {++last_id_, topic.name, "cdr", topic.type, *schema, "ros2msg"};
    relayed.publishers = topic.publishers;
    come.push_back(relayed.channel);
  }
  std::vector<std::uint32_t> gone;
  std::erase_if(relayed_, [&](const auto& entry) {
    const bool is_gone = !entry.second.publishers.empty() && !here.contains(entry.first);
    if (is_gone) gone.push_back(entry.second.channel.id);
    return is_gone;
  });
  if (!come.empty()) web_.send_text(clients, foxglove::advertise(come));
  if (!gone.empty()) web_.send_text(clients, foxglove::unadvertise(gone));
  if (!come.empty() || !gone.empty()) announcement_.reset();
}

void TopicRelay::announce_all(ClientId client) {
  if (!announcement_) {
    std::vector<foxglove::Channel> all;
    for (const auto& [key, relayed] : relayed_) all.push_back(relayed.channel);
    announcement_ = body_of(foxglove::advertise(all));
  }
  web_.answer(client, {true, {}, announcement_, true});
}

void TopicRelay::forget(ClientId client) {
  channels_.erase(client);
  for (auto& [key, relayed] : relayed_)
    std::erase_if(relayed.listeners, [&](const auto& l) { return l.client == client; });
}

TopicRelay::Relayed* TopicRelay::find(std::uint32_t channel) {
  const auto found = std::find_if(relayed_.begin(), relayed_.end(), [&](const auto& entry) {
    return entry.second.channel.id == channel;
  });
  return found == relayed_.end() ? nullptr : &found->second;
}

void TopicRelay::subscribe(ClientId client, const foxglove::Subscribe& request) {
  std::erase_if(channels_[client],
                [&](const auto& entry) { return find(entry.second) == nullptr; });
  Complaints complaints;
  if (request.all.size() > kMaxSubscriptions)
    complaints.add("at most " + std::to_string(kMaxSubscriptions) +
                   " subscriptions in one request");
  else
    for (const auto& one : request.all) complaints.add(subscribe(client, one));
  if (const auto text = complaints.text(); !text.empty())
    web_.answer(client, {true, foxglove::status(foxglove::Level::kWarning, text)});
}

// Returns an error message; empty on success.
std::string TopicRelay::subscribe(ClientId client, const foxglove::Subscribe::One& wanted) {
  Relayed* relayed = find(wanted.channel);
  auto& channels = channels_[client];
  if (relayed == nullptr) return "there is no channel " + std::to_string(wanted.channel);
  if (channels.contains(wanted.subscription))
    return "subscription " + std::to_string(wanted.subscription) + " is already in use";
  if (channels.size() >= kMaxSubscriptions)
    return "at most " + std::to_string(kMaxSubscriptions) + " subscriptions";
  if (std::count_if(channels.begin(), channels.end(),
                    [&](const auto& entry) { return entry.second == wanted.channel; }) >= kMaxOfOne)
    return "at most " + std::to_string(kMaxOfOne) + " subscriptions of one channel";
  if (!relayed->listening) web_.charge(client, kReaderCost);
  channels[wanted.subscription] = wanted.channel;
  relayed->listeners.push_back({client, wanted.subscription});
  for (const auto& [sender, last] : relayed->last) {
    web_.charge(client, kCostPerByte * static_cast<double>(last->size()));
    send(relayed->listeners.back(), last);
  }
  return {};
}

void TopicRelay::unsubscribe(ClientId client, const foxglove::Unsubscribe& request) {
  for (const auto subscription : request.subscriptions) unsubscribe(client, subscription);
}

void TopicRelay::unsubscribe(ClientId client, std::uint32_t subscription) {
  auto& channels = channels_[client];
  const auto channel = channels.find(subscription);
  if (channel == channels.end()) return;
  if (Relayed* relayed = find(channel->second))
    std::erase_if(relayed->listeners, [&](const Listener& l) {
      return l.client == client && l.subscription == subscription;
    });
  channels.erase(channel);
}

// One per tick: creating a reader takes a millisecond here and some time in every other process.
void TopicRelay::listen_to_next() {
  const auto wanted = std::find_if(relayed_.begin(), relayed_.end(), [](const auto& entry) {
    return !entry.second.listening && !entry.second.listeners.empty();
  });
  if (wanted == relayed_.end()) return;
  Relayed& relayed = wanted->second;
  try {
    listen(relayed);
  } catch (const std::exception& error) {  // names and types from other software may be invalid
    for (const auto& [client, subscription] : std::exchange(relayed.listeners, {})) {
      channels_[client].erase(subscription);
      web_.answer(client, {true, foxglove::status(foxglove::Level::kError, error.what())});
    }
  }
}

// Throws what the runtime throws for invalid names and types.
void TopicRelay::listen(Relayed& relayed) {
  rt::QoS qos = rt::request_for(relayed.publishers, kDepth);
  relayed.latched = qos.durability == rt::Durability::kTransientLocal;
  if (relayed.latched) qos.depth = kMaxKept;
  relayed.subscription =
      node_.create_generic_subscription(relayed.channel.topic, relayed.channel.schema_name, qos,
                                        [this, id = relayed.channel.id](const auto& bytes) {
                                          if (Relayed* to = find(id)) relay(*to, bytes);
                                        });
  relayed.listening = true;
}

void TopicRelay::relay(Relayed& relayed, const std::vector<std::uint8_t>& bytes) {
  const auto body = std::make_shared<const std::vector<std::uint8_t>>(bytes);
  if (relayed.latched) {  // keep each publisher's newest message, at the end
    const rt::PublisherId sender = relayed.subscription.sender();
    std::erase_if(relayed.last, [&](const auto& last) { return last.first == sender; });
    if (relayed.last.size() < kMaxKept) relayed.last.emplace_back(sender, body);
  }
  for (const auto& listener : relayed.listeners) send(listener, body);
}

void TopicRelay::send(const Listener& to, const Body& body) {
  const auto now = static_cast<std::uint64_t>(rt::system_nanoseconds());
  web_.send(to.client, {false, foxglove::message_head(to.subscription, now), body, true});
}

// Unused readers are removed with a delay, so that a reconnecting client does not make the domain
// discover a reader each time, and one per look, because destroying a reader takes time.
void TopicRelay::rest() {
  const double now = node_.steady_now();
  bool rested = false;
  for (auto& [key, relayed] : relayed_) {
    if (!relayed.listeners.empty() || relayed.publishers.empty() || !relayed.listening) {
      relayed.unused_since = now;
    } else if (!rested && now - relayed.unused_since > kRest) {
      relayed.subscription = {};
      relayed.listening = false;
      relayed.last.clear();
      rested = true;
    }
  }
}

void TopicRelay::send_own(ClientId client, std::uint32_t channel, const std::string& payload) {
  const Relayed* const own = find(channel);
  if (own == nullptr) return;
  const auto body = body_of(payload);
  for (const auto& listener : own->listeners)
    if (listener.client == client) send(listener, body);
}

}  // namespace tandem
