// SPDX-License-Identifier: Apache-2.0
// Provides the DomainParticipant that all nodes of the process share. Private to runtime/.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/detail/direct_topic.hpp"
#include "tandem/runtime/detail/discovery.hpp"
#include "tandem/runtime/environment.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

class ClockSource;
class Graph;
class Participant;
struct Endpoint;

/// Shared ownership of a DDS topic; the last owner deletes it. Fast DDS 2.9 allows one type per
/// topic name and participant, so a name already used with another type is created in a second
/// participant.
class SharedTopic {
 public:
  /// Throws std::runtime_error if the name is in use with two other types.
  SharedTopic(Participant& first, const std::string& dds_name, const std::string& dds_type);
  ~SharedTopic();
  SharedTopic(const SharedTopic&) = delete;
  SharedTopic& operator=(const SharedTopic&) = delete;

  [[nodiscard]] Participant& participant() const { return *participant_; }
  [[nodiscard]] fdds::Topic* dds() const { return dds_; }

 private:
  Participant* participant_;
  std::string name_;
  fdds::Topic* dds_;
};

/// The process's DomainParticipant; exists as long as any node does. Uses UDPv4 unless an XML
/// profiles file names other transports; all UDP transports are behind the process's WireGuard.
class TANDEM_EXPORT_FOR_TESTS Participant {
 public:
  /// The participant of this process, created on first use. Throws std::runtime_error if the
  /// environment is invalid or DDS refuses to create it.
  static std::shared_ptr<Participant> shared();
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  [[nodiscard]] fdds::DomainParticipant& dds() { return *dds_; }
  [[nodiscard]] fdds::Publisher& publisher() { return *publisher_; }
  [[nodiscard]] fdds::Subscriber& subscriber() { return *subscriber_; }
  [[nodiscard]] Graph& graph() { return *graph_; }
  /// Publishes which nodes and endpoints have ended. A node that spins calls it once a second; it
  /// does not wait for other threads.
  void publish_ends();
  [[nodiscard]] Discovery& discovery() { return discovery_; }
  /// The process's reader of a clock topic with that QoS; exists as long as anybody follows it.
  [[nodiscard]] std::shared_ptr<ClockSource> clock(const Endpoint& endpoint);
  /// What the process's publishers and subscriptions of a topic share, by DDS names.
  [[nodiscard]] std::shared_ptr<DirectTopic> direct_topic(const std::string& topic,
                                                          const std::string& type) {
    return direct_topics_.of(topic, type);
  }
  [[nodiscard]] int domain() const { return environment_.domain; }
  /// Whether to communicate with ROS 2 Humble: Gids of 24 bytes, no type hashes.
  [[nodiscard]] bool speaks_humble() const { return environment_.humble; }
  [[nodiscard]] const Security& security() const { return security_; }
  /// Whether `guid` belongs to a participant of this process.
  [[nodiscard]] bool is_own(const rtps::GUID_t& guid);

 private:
  friend class SharedTopic;
  Participant(const Environment& environment, const Security& security, bool is_first);
  [[nodiscard]] Participant& second();
  // Returns null if the name is in use with another type.
  fdds::Topic* acquire_topic(const std::string& dds_name, const std::string& dds_type);
  void release_topic(const std::string& dds_name);
  void register_type(const std::string& dds_type);

  struct TopicUse {
    fdds::Topic* dds;
    std::string type;
    int users;
  };

  Environment environment_;
  Security security_;
  Discovery discovery_;
  DirectTopics direct_topics_;
  fdds::DomainParticipant* dds_ = nullptr;
  fdds::Publisher* publisher_ = nullptr;
  fdds::Subscriber* subscriber_ = nullptr;
  std::mutex mutex_;  // guards the members below
  std::map<std::string, fdds::TypeSupport> types_;
  std::map<std::string, TopicUse> topics_;
  std::unique_ptr<Graph> graph_;
  std::unique_ptr<Participant> second_;
  std::atomic<Participant*> known_second_ = nullptr;  // is read without mutex_
  std::mutex clocks_mutex_;  // guards clocks_, whose readers use mutex_ when they are made
  std::vector<std::weak_ptr<ClockSource>> clocks_;
};

}  // namespace tandem::runtime
