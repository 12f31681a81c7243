// SPDX-License-Identifier: Apache-2.0
// Lists the domain's discovered publishers and subscriptions. Private to runtime/.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/detail/discovery_watcher.hpp"
#include "tandem/runtime/qos.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A publisher or a subscription of this process or another.
struct KnownEndpoint {
  rtps::GUID_t guid;
  bool writes = false;
  std::string topic, type;  ///< DDS names
  Policies policies;
  std::string user_data{};  ///< "typehash=…;"
  double since = 0.0;       ///< when it was first seen [s], steady clock

  bool operator==(const KnownEndpoint&) const = default;
};

/// Sorted by GUID.
using KnownEndpoints = std::vector<std::shared_ptr<const KnownEndpoint>>;

/// The type hash ("RIHS01_…") in an endpoint's user data; empty if there is none.
[[nodiscard]] TANDEM_EXPORT_FOR_TESTS std::string type_hash_in(const std::string& user_data);

/// Whether two endpoints belong to the same process, or to the same enclave under DDS Security,
/// which hides the process.
[[nodiscard]] bool same_process(const rtps::GUID_t& a, const rtps::GUID_t& b);

/// All discovered endpoints of the domain. Thread-safe.
class TANDEM_EXPORT_FOR_TESTS Discovery final : public fdds::DomainParticipantListener {
 public:
  /// Adds an endpoint of this participant, which DDS does not report.
  void add(KnownEndpoint endpoint);
  void remove(const rtps::GUID_t& guid);

  [[nodiscard]] KnownEndpoints endpoints() const;
  /// Those on a topic, given by its DDS name.
  [[nodiscard]] KnownEndpoints endpoints_on(const std::string& topic) const;
  /// The QoS an endpoint offers or requests; nullopt if it is unknown or has left.
  [[nodiscard]] std::optional<Policies> policies(const rtps::GUID_t& guid) const;
  /// The UDP ports on which a discovered participant receives discovery; empty if it is unknown.
  [[nodiscard]] std::vector<std::uint32_t> ports(const rtps::GuidPrefix_t& participant) const;
  /// Notes every change with the watcher for as long as it exists.
  void add(const std::shared_ptr<DiscoveryWatcher>& watcher);

#if TANDEM_FASTDDS_3
  void on_participant_discovery(fdds::DomainParticipant*, rtps::ParticipantDiscoveryStatus status,
                                const rtps::ParticipantBuiltinTopicData& info, bool&) override;
  void on_data_writer_discovery(fdds::DomainParticipant*, rtps::WriterDiscoveryStatus status,
                                const rtps::PublicationBuiltinTopicData& info, bool&) override;
  void on_data_reader_discovery(fdds::DomainParticipant*, rtps::ReaderDiscoveryStatus status,
                                const rtps::SubscriptionBuiltinTopicData& info, bool&) override;
#else
  void on_participant_discovery(fdds::DomainParticipant*,
                                rtps::ParticipantDiscoveryInfo&& info) override;
  void on_publisher_discovery(fdds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override;
  void on_subscriber_discovery(fdds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) override;
#endif

 private:
  using ByGuid = std::map<rtps::GUID_t, std::shared_ptr<const KnownEndpoint>>;

  void note_change(const std::string& topic);
  void erase_from_topic(const KnownEndpoint& endpoint);  // with the mutex locked
  void set_ports(const rtps::GuidPrefix_t& participant, std::vector<std::uint32_t> ports);

  mutable std::mutex mutex_;  // guards the members below
  ByGuid endpoints_;
  std::unordered_map<std::string, ByGuid> topics_;  // the same by topic
  std::map<rtps::GuidPrefix_t, std::vector<std::uint32_t>> ports_;
  std::vector<std::weak_ptr<DiscoveryWatcher>> watchers_;
};

}  // namespace tandem::runtime
