// SPDX-License-Identifier: Apache-2.0
// Compares a node's endpoints with the discovered ones and reports mismatches. Private to runtime/.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tandem/runtime/detail/discovery.hpp"
#include "tandem/runtime/detail/discovery_watcher.hpp"
#include "tandem/runtime/detail/endpoint.hpp"
#include "tandem/runtime/log.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Logs, once per peer, which peers cannot communicate with a node and why, and runs callbacks that
/// wait for a publisher of a type. Use on the node's thread only.
class TANDEM_EXPORT_FOR_TESTS PeerWatch {
 public:
  /// `settling`: time [s] before a peer is reported; it may still open a compatible endpoint.
  /// Discovery notifies `wake_up`, of the node's thread, when due() changes.
  PeerWatch(Discovery& discovery, Logger& log, double settling, std::shared_ptr<WakeUp> wake_up);

  void add(const rtps::GUID_t& guid, const Endpoint& endpoint, bool writes);
  void remove(const rtps::GUID_t& guid);

  /// As Node::watch_publishers(), for DDS names.
  [[nodiscard]] std::shared_ptr<void> watch_publishers(const std::string& topic,
                                                       const std::string& type,
                                                       PublishersChanged fn);

  /// When to call poll() [s], steady clock; infinity if nothing has changed and no peer is too new
  /// to be reported.
  [[nodiscard]] double due() const;
  /// Runs the checks and callbacks due at `now` [s].
  void poll(double now);

 private:
  struct Own {
    rtps::GUID_t guid;
    bool writes;
    Endpoint endpoint;
  };
  struct Request {
    std::string topic, type;
    PublishersChanged fn;
    std::set<rtps::GUID_t> reported;  // the publishers last passed to fn
  };

  [[nodiscard]] std::set<std::string> topics_to_look_at(double now);
  [[nodiscard]] std::set<std::string> own_topics() const;
  void look_at(const std::string& topic, double now);
  void notify_requests(const std::string& topic, const KnownEndpoints& known);
  static void notify(Request& request, const KnownEndpoints& known);
  void check(const std::string& topic, const KnownEndpoints& known, double now);
  void check(const KnownEndpoint& peer, const KnownEndpoints& known);
  [[nodiscard]] bool receives_other_type(const KnownEndpoint& peer,
                                         const KnownEndpoints& known) const;

  const Discovery& discovery_;
  Logger& log_;
  double settling_;  // [s]
  std::vector<Own> own_;
  std::vector<std::weak_ptr<Request>> requests_;
  std::map<std::string, std::set<rtps::GUID_t>> checked_;  // by topic
  std::map<std::string, double> settles_;     // when to look at a topic with new peers again [s]
  std::shared_ptr<DiscoveryWatcher> others_;  // on which topics discovered endpoints have changed
  bool own_changed_ = true;                   // own_ or requests_, since the last poll
  double polled_;                             // [s] when last
};

}  // namespace tandem::runtime
