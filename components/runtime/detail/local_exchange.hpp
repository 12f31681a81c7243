// SPDX-License-Identifier: Apache-2.0
// What the nodes of a LocalBus share: its events, topics and services. Private to runtime/.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tandem/runtime/detail/event_queue.hpp"
#include "tandem/runtime/local_bus.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/service.hpp"

namespace tandem::runtime {

class LocalClient;
class LocalReader;
class LocalServer;
class LocalWriter;

/// A topic under one of its types.
struct LocalTopic {
  std::vector<std::shared_ptr<LocalReader>> readers;
  std::vector<std::shared_ptr<LocalWriter>> writers;
  struct Watch {
    PublishersChanged fn;
    bool is_due = true;  // the publishers have changed since the last call
  };
  std::vector<std::weak_ptr<Watch>> watches;
};

/// Matches publishers with subscriptions and clients with servers.
class LocalExchange {
 public:
  explicit LocalExchange(unsigned seed) : random_{seed} {}

  [[nodiscard]] EventQueue& events() { return events_; }

  void open(const std::shared_ptr<LocalWriter>& writer);
  void open(const std::shared_ptr<LocalReader>& reader);
  void open(const std::shared_ptr<LocalServer>& server);
  void close(LocalWriter& writer);
  void close(LocalReader& reader);
  void close(LocalServer& server);

  [[nodiscard]] std::shared_ptr<void> watch_publishers(const std::string& topic,
                                                       const std::string& type,
                                                       PublishersChanged fn);

  /// The server that answers requests of this type, null if there is none.
  [[nodiscard]] std::shared_ptr<LocalServer> server(const std::string& service,
                                                    const std::string& request_type) const;
  /// Has `client` called again as soon as a server of the service is opened.
  void wait_for_server(const std::string& service, const std::shared_ptr<LocalClient>& client);

  [[nodiscard]] PublisherId new_id();
  void forget(const PublisherId& id) { ids_.erase(id); }
  [[nodiscard]] bool is_present(const PublisherId& id) const { return ids_.contains(id); }
  [[nodiscard]] std::size_t count_publishers(const std::string& topic) const;
  [[nodiscard]] std::vector<TopicInfo> topics() const;
  [[nodiscard]] std::vector<ServiceInfo> services() const;

  void disturb(const std::string& topic, const LinkFaults& faults);
  [[nodiscard]] const LinkFaults& faults_of(const std::string& topic) const;
  /// Uniformly distributed in [0, 1).
  [[nodiscard]] double draw() { return std::generate_canonical<double, 53>(random_); }

  /// Time that the callbacks of a node have taken [s]; the reference stays valid.
  [[nodiscard]] double& busy(const std::string& node) { return busy_[node]; }
  void count_delivery() { ++delivered_; }
  [[nodiscard]] std::uint64_t delivered() const { return delivered_; }

 private:
  using Key = std::pair<std::string, std::string>;  // name and type
  void notify(LocalTopic& topic);

  EventQueue events_;
  std::map<Key, LocalTopic> topics_;
  std::map<Key, std::vector<std::shared_ptr<LocalServer>>> servers_;
  std::map<std::string, std::vector<std::weak_ptr<LocalClient>>> waiting_;  // key: service
  std::map<std::string, LinkFaults> faults_;                                // key: topic
  std::map<std::string, double> busy_;                                      // key: node
  std::set<PublisherId> ids_;
  std::uint64_t last_id_ = 0;
  std::mt19937_64 random_;
  std::uint64_t delivered_ = 0;
};

}  // namespace tandem::runtime
