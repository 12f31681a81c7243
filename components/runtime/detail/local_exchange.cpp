// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/local_exchange.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "tandem/runtime/detail/local_endpoints.hpp"
#include "tandem/runtime/detail/local_services.hpp"

namespace tandem::runtime {
namespace {

template <class T>
void erase(std::vector<std::shared_ptr<T>>& list, const T& item) {
  std::erase_if(list, [&](const auto& element) { return element.get() == &item; });
}

std::vector<Policies> offered_by(const LocalTopic& topic) {
  std::vector<Policies> offered;
  for (const auto& writer : topic.writers) offered.push_back(policies_of(writer->qos()));
  return offered;
}

}  // namespace

void LocalExchange::open(const std::shared_ptr<LocalWriter>& writer) {
  LocalTopic& topic = topics_[{writer->topic(), writer->type()}];
  topic.writers.push_back(writer);
  for (const auto& reader : topic.readers) match(*writer, reader);
  notify(topic);
}

void LocalExchange::open(const std::shared_ptr<LocalReader>& reader) {
  LocalTopic& topic = topics_[{reader->topic(), reader->type()}];
  topic.readers.push_back(reader);
  for (const auto& writer : topic.writers) match(*writer, reader);
}

void LocalExchange::close(LocalWriter& writer) {
  forget(writer.id());
  LocalTopic& topic = topics_[{writer.topic(), writer.type()}];
  for (const auto& reader : topic.readers) unmatch(writer, *reader);
  erase(topic.writers, writer);
  notify(topic);
}

void LocalExchange::close(LocalReader& reader) {
  LocalTopic& topic = topics_[{reader.topic(), reader.type()}];
  for (const auto& writer : topic.writers) unmatch(*writer, reader);
  erase(topic.readers, reader);
}

// Callbacks may open and close endpoints, so that they run as an event of their own.
void LocalExchange::notify(LocalTopic& topic) {
  std::erase_if(topic.watches, [](const auto& watch) { return watch.expired(); });
  for (const auto& weak : topic.watches) {
    weak.lock()->is_due = true;
    events_.post([&topic, weak] {
      const auto watch = weak.lock();
      if (watch && std::exchange(watch->is_due, false)) watch->fn(offered_by(topic));
    });
  }
}

std::shared_ptr<void> LocalExchange::watch_publishers(const std::string& topic,
                                                      const std::string& type,
                                                      PublishersChanged fn) {
  auto watch = std::make_shared<LocalTopic::Watch>(LocalTopic::Watch{std::move(fn)});
  LocalTopic& watched = topics_[{topic, type}];
  watched.watches.push_back(watch);
  if (!watched.writers.empty()) notify(watched);
  return watch;
}

void LocalExchange::open(const std::shared_ptr<LocalServer>& server) {
  servers_[{server->service(), server->request_type()}].push_back(server);
  const auto waiting = waiting_.extract(server->service());
  if (waiting.empty()) return;
  for (const auto& weak : waiting.mapped())
    events_.post([weak] {
      if (const auto client = weak.lock()) client->send_waiting();
    });
}

void LocalExchange::close(LocalServer& server) {
  erase(servers_[{server.service(), server.request_type()}], server);
}

std::shared_ptr<LocalServer> LocalExchange::server(const std::string& service,
                                                   const std::string& request_type) const {
  const auto found = servers_.find({service, request_type});
  return found == servers_.end() || found->second.empty() ? nullptr : found->second.front();
}

void LocalExchange::wait_for_server(const std::string& service,
                                    const std::shared_ptr<LocalClient>& client) {
  waiting_[service].push_back(client);
}

PublisherId LocalExchange::new_id() {
  PublisherId id{};
  std::uint64_t number = ++last_id_;
  for (auto byte = id.rbegin(); number != 0; ++byte, number >>= 8U)
    *byte = static_cast<std::uint8_t>(number & 0xFFU);
  ids_.insert(id);
  return id;
}

std::size_t LocalExchange::count_publishers(const std::string& topic) const {
  std::size_t count = 0;
  for (const auto& [key, endpoints] : topics_)
    if (key.first == topic) count += endpoints.writers.size();
  return count;
}

std::vector<TopicInfo> LocalExchange::topics() const {
  std::vector<TopicInfo> all;
  for (const auto& [key, topic] : topics_) {
    if (topic.writers.empty() && topic.readers.empty()) continue;
    TopicInfo info;
    info.name = key.first;
    info.type = key.second;
    info.publishers = offered_by(topic);
    for (const auto& reader : topic.readers)
      info.subscriptions.push_back(policies_of(reader->qos()));
    all.push_back(std::move(info));
  }
  return all;
}

std::vector<ServiceInfo> LocalExchange::services() const {
  constexpr std::string_view kRequest = "_Request";
  std::vector<ServiceInfo> all;
  for (const auto& [key, servers] : servers_)
    if (!servers.empty())
      all.push_back({key.first, key.second.substr(0, key.second.size() - kRequest.size())});
  return all;
}

void LocalExchange::disturb(const std::string& topic, const LinkFaults& faults) {
  if (!(faults.delay >= 0.0 && faults.jitter >= 0.0 && faults.loss >= 0.0 && faults.loss <= 1.0))
    throw std::invalid_argument(
        fmt::format("faults of `{}`: delay {} s and jitter {} s must not be negative, loss {} must "
                    "be in [0, 1]",
                    topic, faults.delay, faults.jitter, faults.loss));
  faults_[topic] = faults;
}

const LinkFaults& LocalExchange::faults_of(const std::string& topic) const {
  static const LinkFaults none;
  auto found = faults_.find(topic);
  if (found == faults_.end()) found = faults_.find("");
  return found == faults_.end() ? none : found->second;
}

}  // namespace tandem::runtime
