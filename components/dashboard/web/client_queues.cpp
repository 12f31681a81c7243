// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/client_queues.hpp"

#include <algorithm>
#include <utility>

namespace tandem {
namespace {

bool is_urgent(const WebEvent& frame, const std::vector<std::string>& prefixes) {
  return frame.kind == WebEvent::Kind::kBinary &&
         std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const std::string& prefix) { return frame.bytes.starts_with(prefix); });
}

WebEvent pop(std::deque<WebEvent>& queue) {
  WebEvent first = std::move(queue.front());
  queue.pop_front();
  return first;
}

}  // namespace

void ClientQueues::join(ClientId client, double now) { clients_.try_emplace(client, now); }

bool ClientQueues::push(WebEvent frame) {
  const auto found = clients_.find(frame.client);
  if (found == clients_.end()) return false;
  Client& client = found->second;
  if (is_urgent(frame, client.prefixes)) return push_urgent(client, std::move(frame));
  if (client.usual.size() >= limits_.frames || client.bytes + frame.bytes.size() > limits_.bytes)
    return false;
  client.bytes += frame.bytes.size();
  client.usual.push_back(std::move(frame));
  return true;
}

// Dropping a repeated frame loses nothing: it would have the same effect twice.
bool ClientQueues::push_urgent(Client& client, WebEvent frame) const {
  if (!client.urgent.empty() && client.urgent.back().bytes == frame.bytes) return true;
  if (client.urgent.size() >= limits_.urgent) return false;
  client.urgent.push_back(std::move(frame));
  return true;
}

void ClientQueues::leave(ClientId client) {
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  if (found->second.announced)
    found->second.left = true;
  else
    clients_.erase(found);
}

void ClientQueues::set_urgent(ClientId id, std::vector<std::string> prefixes) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  Client& client = found->second;
  client.prefixes = std::move(prefixes);
  std::deque<WebEvent> usual;
  for (auto& frame : client.usual)
    if (!is_urgent(frame, client.prefixes)) {
      usual.push_back(std::move(frame));
    } else {
      client.bytes -= frame.bytes.size();
      client.urgent.push_back(std::move(frame));
    }
  client.usual = std::move(usual);
}

std::optional<WebEvent> ClientQueues::next(Lane lane, double now) {
  switch (lane) {
    case Lane::kUrgent:
      return next_urgent();
    case Lane::kLastWords:
      return next_usual(true, now);
    case Lane::kLeft:
      return next_left();
    case Lane::kJoined:
      return next_joined();
    case Lane::kUsual:
      return next_usual(false, now);
  }
  return std::nullopt;
}

std::optional<WebEvent> ClientQueues::next_urgent() {
  const auto has_some = [](const auto& entry) { return !entry.second.urgent.empty(); };
  const auto after = clients_.upper_bound(last_urgent_);
  auto next = std::find_if(after, clients_.end(), has_some);
  if (next == clients_.end()) next = std::find_if(clients_.begin(), after, has_some);
  if (next == clients_.end() || !has_some(*next)) return std::nullopt;
  last_urgent_ = next->first;
  return pop(next->second.urgent);
}

// Remaining frames of the client are discarded, except an emergency stop.
std::optional<WebEvent> ClientQueues::next_left() {
  const auto found = std::find_if(clients_.begin(), clients_.end(), [](const auto& entry) {
    return entry.second.left && entry.second.urgent.empty();
  });
  if (found == clients_.end()) return std::nullopt;
  const ClientId client = found->first;
  clients_.erase(found);
  return WebEvent{client, WebEvent::Kind::kLeft, {}};
}

std::optional<WebEvent> ClientQueues::next_joined() {
  const auto found = std::find_if(clients_.begin(), clients_.end(),
                                  [](const auto& entry) { return !entry.second.announced; });
  if (found == clients_.end()) return std::nullopt;
  found->second.announced = true;
  return WebEvent{found->first, WebEvent::Kind::kJoined, {}};
}

std::optional<WebEvent> ClientQueues::next_usual(bool left, double now) {
  Client* best = nullptr;
  double most = 0.0;
  for (auto& [id, client] : clients_) {
    if (client.usual.empty() || !client.announced || client.left != left) continue;
    if (const double work = client.budget.left(now); work > most) {
      best = &client;
      most = work;
    }
  }
  if (best == nullptr) return std::nullopt;
  WebEvent frame = pop(best->usual);
  best->bytes -= frame.bytes.size();
  return frame;
}

void ClientQueues::charge(ClientId client, double work, double now) {
  if (const auto found = clients_.find(client); found != clients_.end())
    found->second.budget.charge(work, now);
}

}  // namespace tandem
