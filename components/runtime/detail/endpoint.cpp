// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/endpoint.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/dds_log.hpp"
#include "tandem/runtime/detail/wake_up.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/time.hpp"
#include "type_hashes.hpp"

namespace tandem::runtime {
namespace {

constexpr int kBatch = 32;               // maximum samples of one topic per turn
constexpr std::size_t kMaxWriters = 64;  // maximum number of writers in transit_
// Maximum wait of a reliable write [s]; longer for what is written rarely and must not be lost,
// such as a pressed emergency stop.
constexpr double kMaxBlocking = 0.010, kMaxBlockingLatched = 0.1;
constexpr double kHeartbeat = 0.1;  // [s] until a reader notices a lost sample
// [s] until a new reader requests the samples it missed; doubles until it is answered. The default
// of 0.07 s is too long for a program that publishes once and exits.
constexpr double kFirstRequest = 0.005;
// Types whose largest sample [bytes] does not exceed this use a preallocated pool, because only
// then does Fast DDS reject larger samples. Other types free each sample's memory after use.
constexpr std::size_t kMaxPreallocated = std::size_t{1} << 20;
constexpr std::size_t kMaxKept = std::size_t{1} << 20;  // buffer kept for the next sample [bytes]

template <class DdsQos>
void set_common(DdsQos& dds, const Participant& participant, const Endpoint& endpoint) {
  const QoS& qos = endpoint.qos;
  const std::string user_data = endpoint.user_data(participant.speaks_humble());
  dds.user_data().data_vec({user_data.begin(), user_data.end()});
  const bool reliable = qos.reliability == Reliability::kReliable;
  dds.reliability().kind =
      reliable ? fdds::RELIABLE_RELIABILITY_QOS : fdds::BEST_EFFORT_RELIABILITY_QOS;
  const bool latched = qos.durability == Durability::kTransientLocal;
  dds.reliability().max_blocking_time = to_duration(latched ? kMaxBlockingLatched : kMaxBlocking);
  dds.durability().kind =
      latched ? fdds::TRANSIENT_LOCAL_DURABILITY_QOS : fdds::VOLATILE_DURABILITY_QOS;
  dds.history().kind = fdds::KEEP_LAST_HISTORY_QOS;
  dds.history().depth = qos.depth;
  dds.resource_limits().max_samples_per_instance = std::max(400, qos.depth);
  dds.resource_limits().allocated_samples = 0;  // allocated on demand
  dds.data_sharing().off();
}

fdds::DataReaderQos reader_qos(const Participant& participant, const Endpoint& endpoint) {
  fdds::DataReaderQos dds = fdds::DATAREADER_QOS_DEFAULT;
  set_common(dds, participant, endpoint);
  dds.endpoint().history_memory_policy =
      largest_sample_of(ros_type(endpoint.type)) <= kMaxPreallocated
          ? rtps::PREALLOCATED_MEMORY_MODE
          : rtps::DYNAMIC_RESERVE_MEMORY_MODE;
#if TANDEM_FASTDDS_3
  dds.representation().m_value = {fdds::XCDR_DATA_REPRESENTATION};
  dds.reliable_reader_qos().times.initial_acknack_delay = to_duration(kFirstRequest);
#else
  dds.type_consistency().representation.m_value = {fdds::XCDR_DATA_REPRESENTATION};
  dds.reliable_reader_qos().times.initialAcknackDelay = to_duration(kFirstRequest);
#endif
  return dds;
}

fdds::DataWriterQos writer_qos(const Participant& participant, const Endpoint& endpoint) {
  fdds::DataWriterQos dds = fdds::DATAWRITER_QOS_DEFAULT;
  set_common(dds, participant, endpoint);
  dds.representation().m_value = {fdds::XCDR_DATA_REPRESENTATION};
  dds.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  dds.lifespan().duration = to_duration(endpoint.qos.lifespan);
#if TANDEM_FASTDDS_3
  dds.reliable_writer_qos().times.heartbeat_period = to_duration(kHeartbeat);
#else
  dds.reliable_writer_qos().times.heartbeatPeriod = to_duration(kHeartbeat);
#endif
  return dds;
}

// Calls `create`; throws std::runtime_error if DDS refuses `what`.
template <class Create>
auto created(const SharedTopic& topic, const std::string& what, Create create) {
  const DdsErrors errors;
  auto* endpoint = create();
  if (endpoint != nullptr) return endpoint;
  const std::string reason = errors.first();
  const Security& security = topic.participant().security();
  throw std::runtime_error("DDS refused to create " + what + (reason.empty() ? "" : ": " + reason) +
                           (security.on() ? "; the permissions of this process are in " +
                                                security.folder + "/permissions.xml"
                                          : ""));
}

// Fast DDS 2.9.1 removes a reader from a list of its participant without the lock under which it
// adds one (WLP::remove_local_reader), but nodes open and close subscriptions on threads of their
// own.
std::mutex readers_of_process;

fdds::DataReader* make_reader(const SharedTopic& topic, const Participant& participant,
                              const Endpoint& endpoint) {
  const std::lock_guard lock{readers_of_process};
  return created(topic, "a subscription to " + ros_name(endpoint.topic), [&] {
    return topic.participant().subscriber().create_datareader(
        topic.dds(), reader_qos(participant, endpoint), nullptr, fdds::StatusMask::none());
  });
}

fdds::DataWriter* make_writer(const SharedTopic& topic, const Participant& participant,
                              const Endpoint& endpoint, fdds::DataWriterListener& listener) {
  return created(topic, "a publisher of " + ros_name(endpoint.topic), [&] {
    return topic.participant().publisher().create_datawriter(
        topic.dds(), writer_qos(participant, endpoint), &listener,
        fdds::StatusMask::publication_matched());
  });
}

}  // namespace

std::string Endpoint::user_data(bool humble) const {
  const std::string hash = type_hash.empty() ? std::string{runtime::type_hash(type)} : type_hash;
  return humble || hash.empty() ? "" : "typehash=" + hash + ";";
}

KnownEndpoint Endpoint::known(const rtps::GUID_t& guid, bool writes,
                              const Participant& participant) const {
  return {.guid = guid,
          .writes = writes,
          .topic = topic,
          .type = type,
          .policies = policies_of(qos),
          .user_data = user_data(participant.speaks_humble()),
          .since = steady_seconds()};
}

std::string Endpoint::malformed_text(std::size_t size) const {
  return fmt::format("{} bytes that are not a valid {}", size, ros_type(type));
}

std::string Endpoint::late_text() const {
  return fmt::format("a message that arrived more than {} s late", qos.lifespan);
}

PublisherId to_id(const rtps::GUID_t& guid) {
  PublisherId id{};
  const auto& [prefix, entity] = guid;
  std::copy_n(entity.value, entity.size, std::copy_n(prefix.value, prefix.size, id.begin()));
  return id;
}

rtps::GUID_t to_guid(const PublisherId& id) {
  rtps::GUID_t guid;
  const auto entity = id.begin() + guid.guidPrefix.size;
  std::copy(id.begin(), entity, guid.guidPrefix.value);
  std::copy(entity, id.end(), guid.entityId.value);
  return guid;
}

Reader::Reader(Participant& participant, const Endpoint& endpoint, Deliver deliver, Refused refused)
    : topic_{participant, endpoint.topic, endpoint.type},
      dds_{make_reader(topic_, participant, endpoint)},
      deliver_{std::move(deliver)},
      refused_{std::move(refused)},
      qos_{endpoint.qos} {
  dds_->get_statuscondition().set_enabled_statuses(fdds::StatusMask::data_available());
}

Reader::~Reader() {
  close();
  const std::lock_guard lock{readers_of_process};
  topic_.participant().subscriber().delete_datareader(dds_);
}

void Reader::close() {
  closed_ = true;
  if (queue_) direct_topic_->remove(*queue_);
}

bool Reader::has_bytes() const {
  return waiting_ ||
         (arrival_.fn ? arrival_.any.load() : dds_->get_statuscondition().get_trigger_value());
}

int Reader::drain_samples() {
  int taken = 0;
  for (; taken < kBatch && !closed_ && has_samples(); ++taken)
    if (const auto sample = queue_->pop()) take_one(*sample);
  samples_left_ = taken == kBatch && has_samples();
  return taken;
}

int Reader::drain_bytes() {
  if (!has_bytes()) return 0;
  arrival_.any = false;  // before the samples are taken, so that none is missed
  fdds::SampleInfo info;
  for (int taken = 0; taken < kBatch; ++taken) {
    if (closed_ || !ok(dds_->take_next_sample(&bytes_, &info))) {
      waiting_ = false;
      return taken;
    }
    if (info.valid_data) take_one(info);
    if (bytes_.capacity() > kMaxKept) Bytes{}.swap(bytes_);
  }
  waiting_ = true;  // taking clears the status, so the wait set does not wake up for the rest
  return kBatch;
}

void Reader::receive_directly(std::shared_ptr<DirectTopic> topic, DeliverSample deliver) {
  deliver_sample_ = std::move(deliver);
  direct_topic_ = std::move(topic);
  queue_ = std::make_shared<DirectQueue>(qos_, [this] { direct_arrival_(); });
}

void Reader::on_arrival(std::function<void()> fn, std::function<void()> direct) {
  direct_arrival_ = direct ? std::move(direct) : fn;
  arrival_.fn = std::move(fn);
  dds_->set_listener(&arrival_, fdds::StatusMask::data_available());
  if (queue_) direct_topic_->add(queue_);
}

void Reader::take_one(const Sample& sample) {
  if (steady_seconds() > sample.published + qos_.lifespan) return refused_.late();
  if (deliver_sample_(sample)) return;
  ++malformed_;
  refused_.malformed(sample.bytes().size());
}

void Reader::take_one(const fdds::SampleInfo& info) {
  rtps::iHandle2GUID(sender_, info.publication_handle);
  if (queue_ && queue_->knows(to_id(sender_))) return;  // it has come directly
  if (is_late(info)) return refused_.late();
  if (deliver_(bytes_, info)) return;
  ++malformed_;
  refused_.malformed(bytes_.size());
}

// Replaces DDS's own lifespan check, which compares the clocks of two computers.
bool Reader::is_late(const fdds::SampleInfo& info) {
  if (std::isinf(qos_.lifespan) || info.source_timestamp.seconds() <= 0) return false;
  if (transit_.size() > kMaxWriters) transit_.clear();
  const auto seconds = [](std::int64_t nanoseconds) {
    return 1e-9 * static_cast<double>(nanoseconds);
  };
  return transit_[sender_].is_late(seconds(info.source_timestamp.to_ns()),
                                   seconds(system_nanoseconds()), qos_.lifespan);
}

int Reader::matched() const {
  fdds::SubscriptionMatchedStatus status;
  dds_->get_subscription_matched_status(status);
  return status.current_count;
}

Writer::Writer(Participant& participant, const Endpoint& endpoint)
    : name_{ros_name(endpoint.topic)},
      topic_{participant, endpoint.topic, endpoint.type},
      dds_{make_writer(topic_, participant, endpoint, matches_)} {}

Writer::~Writer() {
  dds_->set_listener(nullptr);
  topic_.participant().publisher().delete_datawriter(dds_);
}

bool Writer::write(const Bytes& bytes) {
  const WakeUp::Deferral until_the_locks_are_released;
  return ok(dds_->write(const_cast<Bytes*>(&bytes)));
}

bool Writer::write(const Bytes& bytes, rtps::WriteParams& params) {
  const WakeUp::Deferral until_the_locks_are_released;
  return ok(dds_->write(const_cast<Bytes*>(&bytes), params));
}

int Writer::matched() const { return matches_.count(); }

Writer::Turn Writer::matched_at(const rtps::GUID_t& peer) const {
  return peer.entityId.is_reader() ? matches_.of(peer) : matches_.latest_of(peer.guidPrefix);
}

// Fast DDS 2.9.1 has one status for all threads that match readers: when one of this process and
// one of another are matched at the same time, both calls may name the same one.
void Writer::Matches::on_publication_matched(fdds::DataWriter*,
                                             const fdds::PublicationMatchedStatus& status) {
  rtps::GUID_t reader;
  rtps::iHandle2GUID(reader, status.last_subscription_handle);
  const std::lock_guard lock{mutex_};
  const bool is_added = status.current_count_change > 0, is_known = readers_.contains(reader);
  if (is_added)
    readers_[reader] = ++turn_;
  else
    readers_.erase(reader);
  if (is_added == is_known || std::abs(status.current_count_change) != 1) is_doubtful_ = true;
  count_of_dds_ = status.current_count;
}

Writer::Turn Writer::Matches::of(const rtps::GUID_t& reader) const {
  const std::lock_guard lock{mutex_};
  const auto found = readers_.find(reader);
  return found == readers_.end() ? 0 : found->second;
}

Writer::Turn Writer::Matches::latest_of(const rtps::GuidPrefix_t& participant) const {
  const std::lock_guard lock{mutex_};
  Turn latest = 0;
  for (const auto& [reader, turn] : readers_)
    if (reader.guidPrefix == participant) latest = std::max(latest, turn);
  return latest;
}

// In doubt there are: their copies of messages that have come directly are dropped.
bool Writer::Matches::has_others_than(const rtps::GUID_t& writer) const {
  const std::lock_guard lock{mutex_};
  return is_doubtful_ || count_of_dds_ != std::ssize(readers_) ||
         std::any_of(readers_.begin(), readers_.end(), [&writer](const auto& reader) {
           return reader.first.guidPrefix != writer.guidPrefix;
         });
}

// In doubt the larger number, because a publisher without readers may make no messages.
int Writer::Matches::count() const {
  const std::lock_guard lock{mutex_};
  const std::int64_t known = std::ssize(readers_);
  return static_cast<int>(is_doubtful_ ? std::max(known, count_of_dds_) : known);
}

}  // namespace tandem::runtime
