// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: the process's one DomainParticipant.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "runtime/dds.hpp"

namespace tandem::runtime {

class Graph;
class Participant;

/// A share in a DDS topic of the participant; the last one to go deletes the topic.
class SharedTopic {
 public:
  /// One type per name. Throws std::runtime_error if the name is in use with another type.
  SharedTopic(Participant& participant, const std::string& dds_name, const std::string& dds_type);
  ~SharedTopic();
  SharedTopic(const SharedTopic&) = delete;
  SharedTopic& operator=(const SharedTopic&) = delete;

  [[nodiscard]] fdds::Topic* dds() const { return dds_; }

 private:
  Participant& participant_;
  std::string name_;
  fdds::Topic* dds_;
};

/// The process's DomainParticipant; exists as long as some node does. UDPv4 only, unless an XML
/// profiles file names other transports.
class Participant {
 public:
  /// The participant of this process, made if there is none. Throws std::runtime_error for an
  /// environment that makes no sense or if DDS refuses.
  static std::shared_ptr<Participant> shared();
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  [[nodiscard]] fdds::DomainParticipant& dds() { return *dds_; }
  [[nodiscard]] fdds::Publisher& publisher() { return *publisher_; }
  [[nodiscard]] fdds::Subscriber& subscriber() { return *subscriber_; }
  [[nodiscard]] Graph& graph() { return *graph_; }
  /// Whether the ROS 2 around is Humble: Gids of 24 bytes, no type hashes.
  [[nodiscard]] bool speaks_humble() const { return humble_; }

 private:
  friend class SharedTopic;
  Participant();
  fdds::Topic* acquire_topic(const std::string& dds_name, const std::string& dds_type);
  void release_topic(const std::string& dds_name);
  void register_type(const std::string& dds_type);

  struct TopicUse {
    fdds::Topic* dds;
    std::string type;
    int users;
  };

  bool humble_ = false;
  fdds::DomainParticipant* dds_ = nullptr;
  fdds::Publisher* publisher_ = nullptr;
  fdds::Subscriber* subscriber_ = nullptr;
  std::mutex mutex_;  // guards types_ and topics_
  std::map<std::string, fdds::TypeSupport> types_;
  std::map<std::string, TopicUse> topics_;
  std::unique_ptr<Graph> graph_;
};

}  // namespace tandem::runtime
