// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/discovery.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string_view>
#include <utility>

#include "tandem/runtime/time.hpp"
#if !TANDEM_FASTDDS_3
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/reader/ReaderDiscoveryInfo.h>
#include <fastdds/rtps/writer/WriterDiscoveryInfo.h>
#endif

namespace tandem::runtime {
namespace {

constexpr std::size_t kMaxEndpoints = 100'000;  // limits memory under a flood of announcements

double seconds(const DdsDuration& duration) {
  if (duration == to_duration(1e9)) return std::numeric_limits<double>::infinity();
  return duration.seconds + 1e-9 * duration.nanosec;
}

// Fast DDS 2.9 reports a WriterQos or ReaderQos, Fast DDS 3 the builtin topic data.
template <class Info>
KnownEndpoint from_builtin(const Info& info, bool writes) {
  KnownEndpoint endpoint;
  endpoint.writes = writes;
#if TANDEM_FASTDDS_3
  endpoint.guid = info.guid;
  endpoint.topic = info.topic_name.to_string();
  endpoint.type = info.type_name.to_string();
  const auto& reliability = info.reliability;
  const auto& durability = info.durability;
  const auto& deadline = info.deadline;
  const auto& liveliness = info.liveliness;
  const auto& user_data = info.user_data;
#else
  endpoint.guid = info.guid();
  endpoint.topic = info.topicName().to_string();
  endpoint.type = info.typeName().to_string();
  const auto& reliability = info.m_qos.m_reliability;
  const auto& durability = info.m_qos.m_durability;
  const auto& deadline = info.m_qos.m_deadline;
  const auto& liveliness = info.m_qos.m_liveliness;
  const auto& user_data = info.m_qos.m_userData;
#endif
  endpoint.policies = {.reliability = reliability.kind == fdds::RELIABLE_RELIABILITY_QOS ? 1 : 0,
                       .durability = static_cast<int>(durability.kind),
                       .deadline = seconds(deadline.period),
                       .liveliness = static_cast<int>(liveliness.kind)};
  endpoint.user_data.assign(user_data.begin(), user_data.end());
  endpoint.since = steady_seconds();
  return endpoint;
}

template <class Map>
KnownEndpoints values_of(const Map& map) {
  KnownEndpoints values;
  values.reserve(map.size());
  for (const auto& [key, value] : map) values.push_back(value);
  return values;
}

template <class Locators>
std::vector<std::uint32_t> ports_of(const Locators& locators) {
  std::vector<std::uint32_t> ports;
  for (const auto& locator : locators) ports.push_back(locator.port);
  return ports;
}

}  // namespace

// "key=value;…"; Lyrical's rmw_fastrtps adds keys of its own.
std::string type_hash_in(const std::string& user_data) {
  constexpr std::string_view kKey = "typehash=";
  for (std::string_view rest = user_data; !rest.empty();) {
    const auto end = std::min(rest.find(';'), rest.size());
    const auto pair = rest.substr(0, end);
    if (pair.starts_with(kKey)) return std::string{pair.substr(kKey.size())};
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return {};
}

bool same_process(const rtps::GUID_t& a, const rtps::GUID_t& b) {
  // The GUID prefix begins with vendor, host and process. Under DDS Security it begins with a hash
  // of the certificate's subject name, whose first bit is set.
  constexpr int kOfProcess = 8;  // [bytes]
  constexpr int kOfSubject = 6;  // [bytes]
  const bool secured = (a.guidPrefix.value[0] & 0x80) != 0;
  return std::equal(a.guidPrefix.value, a.guidPrefix.value + (secured ? kOfSubject : kOfProcess),
                    b.guidPrefix.value);
}

// A server that has been restarted announces everything again; that is no change.
void Discovery::add(KnownEndpoint endpoint) {
  const std::string topic = endpoint.topic;
  std::string left;  // a topic on which it was announced before
  {
    const std::lock_guard lock{mutex_};
    const auto known = endpoints_.find(endpoint.guid);
    if (known == endpoints_.end()) {
      if (endpoints_.size() >= kMaxEndpoints) return;
    } else {
      endpoint.since = known->second->since;
      if (endpoint == *known->second) return;
      left = known->second->topic;
      erase_from_topic(*known->second);
    }
    const auto added = std::make_shared<const KnownEndpoint>(std::move(endpoint));
    endpoints_[added->guid] = added;
    topics_[topic][added->guid] = added;
  }
  note_change(topic);
  if (!left.empty() && left != topic) note_change(left);
}

void Discovery::remove(const rtps::GUID_t& guid) {
  std::string topic;
  {
    const std::lock_guard lock{mutex_};
    const auto known = endpoints_.find(guid);
    if (known == endpoints_.end()) return;
    topic = known->second->topic;
    erase_from_topic(*known->second);
    endpoints_.erase(known);
  }
  note_change(topic);
}

void Discovery::erase_from_topic(const KnownEndpoint& endpoint) {
  const auto topic = topics_.find(endpoint.topic);
  topic->second.erase(endpoint.guid);
  if (topic->second.empty()) topics_.erase(topic);
}

void Discovery::add(const std::shared_ptr<DiscoveryWatcher>& watcher) {
  const std::lock_guard lock{mutex_};
  watchers_.push_back(watcher);
}

void Discovery::note_change(const std::string& topic) {
  std::vector<std::shared_ptr<DiscoveryWatcher>> watchers;
  {
    const std::lock_guard lock{mutex_};
    std::erase_if(watchers_, [](const auto& watcher) { return watcher.expired(); });
    for (const auto& entry : watchers_)
      if (auto watcher = entry.lock()) watchers.push_back(std::move(watcher));
  }
  for (const auto& watcher : watchers) watcher->note_change(topic);
}

KnownEndpoints Discovery::endpoints() const {
  const std::lock_guard lock{mutex_};
  return values_of(endpoints_);
}

KnownEndpoints Discovery::endpoints_on(const std::string& topic) const {
  const std::lock_guard lock{mutex_};
  const auto known = topics_.find(topic);
  return known == topics_.end() ? KnownEndpoints{} : values_of(known->second);
}

std::optional<Policies> Discovery::policies(const rtps::GUID_t& guid) const {
  const std::lock_guard lock{mutex_};
  const auto known = endpoints_.find(guid);
  if (known == endpoints_.end()) return std::nullopt;
  return known->second->policies;
}

std::vector<std::uint32_t> Discovery::ports(const rtps::GuidPrefix_t& participant) const {
  const std::lock_guard lock{mutex_};
  const auto known = ports_.find(participant);
  return known == ports_.end() ? std::vector<std::uint32_t>{} : known->second;
}

void Discovery::set_ports(const rtps::GuidPrefix_t& participant, std::vector<std::uint32_t> ports) {
  const std::lock_guard lock{mutex_};
  if (ports.empty())
    ports_.erase(participant);
  else
    ports_[participant] = std::move(ports);
}

#if TANDEM_FASTDDS_3
void Discovery::on_participant_discovery(fdds::DomainParticipant*,
                                         rtps::ParticipantDiscoveryStatus status,
                                         const rtps::ParticipantBuiltinTopicData& info, bool&) {
  using Status = rtps::ParticipantDiscoveryStatus;
  const bool left = status == Status::REMOVED_PARTICIPANT || status == Status::DROPPED_PARTICIPANT;
  set_ports(info.guid.guidPrefix,
            left ? std::vector<std::uint32_t>{} : ports_of(info.metatraffic_locators.unicast));
}
void Discovery::on_data_writer_discovery(fdds::DomainParticipant*,
                                         rtps::WriterDiscoveryStatus status,
                                         const rtps::PublicationBuiltinTopicData& info, bool&) {
  if (status == rtps::WriterDiscoveryStatus::REMOVED_WRITER)
    remove(info.guid);
  else
    add(from_builtin(info, true));
}
void Discovery::on_data_reader_discovery(fdds::DomainParticipant*,
                                         rtps::ReaderDiscoveryStatus status,
                                         const rtps::SubscriptionBuiltinTopicData& info, bool&) {
  if (status == rtps::ReaderDiscoveryStatus::REMOVED_READER)
    remove(info.guid);
  else
    add(from_builtin(info, false));
}
#else
void Discovery::on_participant_discovery(fdds::DomainParticipant*,
                                         rtps::ParticipantDiscoveryInfo&& info) {
  using Status = rtps::ParticipantDiscoveryInfo;
  const bool left =
      info.status == Status::REMOVED_PARTICIPANT || info.status == Status::DROPPED_PARTICIPANT;
  set_ports(info.info.m_guid.guidPrefix,
            left ? std::vector<std::uint32_t>{} : ports_of(info.info.metatraffic_locators.unicast));
}
void Discovery::on_publisher_discovery(fdds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) {
  if (info.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER)
    remove(info.info.guid());
  else
    add(from_builtin(info.info, true));
}
void Discovery::on_subscriber_discovery(fdds::DomainParticipant*,
                                        rtps::ReaderDiscoveryInfo&& info) {
  if (info.status == rtps::ReaderDiscoveryInfo::REMOVED_READER)
    remove(info.info.guid());
  else
    add(from_builtin(info.info, false));
}
#endif

}  // namespace tandem::runtime
