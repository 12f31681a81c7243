// SPDX-License-Identifier: Apache-2.0
#include "runtime/endpoint.hpp"

#include <algorithm>
#include <stdexcept>

#include "runtime/names.hpp"
#include "type_hashes.hpp"

namespace tandem::runtime {
namespace {

constexpr int kBatch = 32;              // samples of one topic before the others get their turn
constexpr double kMaxBlocking = 0.010;  // [s] that a reliable write may wait
constexpr double kHeartbeat = 0.1;      // [s] until a lost sample is noticed

// Where ROS 2 from Iron on looks for the type's hash; Humble knows none.
template <class DdsQos>
void set_type_hash(DdsQos& dds, const Participant& participant, const std::string& type) {
  const std::string_view hash = type_hash(type);
  if (hash.empty() || participant.speaks_humble()) return;
  const std::string text = "typehash=" + std::string{hash} + ";";
  dds.user_data().data_vec({text.begin(), text.end()});
}

template <class DdsQos>
void set_common(DdsQos& dds, const Participant& participant, const Endpoint& endpoint) {
  const QoS& qos = endpoint.qos;
  set_type_hash(dds, participant, endpoint.type);
  const bool reliable = qos.reliability == Reliability::kReliable;
  dds.reliability().kind =
      reliable ? fdds::RELIABLE_RELIABILITY_QOS : fdds::BEST_EFFORT_RELIABILITY_QOS;
  dds.reliability().max_blocking_time = to_duration(kMaxBlocking);
  dds.durability().kind = qos.durability == Durability::kTransientLocal
                              ? fdds::TRANSIENT_LOCAL_DURABILITY_QOS
                              : fdds::VOLATILE_DURABILITY_QOS;
  dds.history().kind = fdds::KEEP_LAST_HISTORY_QOS;
  dds.history().depth = qos.depth;
  dds.resource_limits().max_samples_per_instance = std::max(400, qos.depth);
  dds.resource_limits().allocated_samples = std::min(100, qos.depth);
  dds.data_sharing().off();
  dds.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
}

fdds::DataReaderQos reader_qos(const Participant& participant, const Endpoint& endpoint) {
  fdds::DataReaderQos dds = fdds::DATAREADER_QOS_DEFAULT;
  set_common(dds, participant, endpoint);
#if TANDEM_FASTDDS_3
  dds.representation().m_value = {fdds::XCDR_DATA_REPRESENTATION};
#else
  dds.type_consistency().representation.m_value = {fdds::XCDR_DATA_REPRESENTATION};
#endif
  return dds;
}

fdds::DataWriterQos writer_qos(const Participant& participant, const Endpoint& endpoint) {
  fdds::DataWriterQos dds = fdds::DATAWRITER_QOS_DEFAULT;
  set_common(dds, participant, endpoint);
  dds.representation().m_value = {fdds::XCDR_DATA_REPRESENTATION};
#if TANDEM_FASTDDS_3
  dds.reliable_writer_qos().times.heartbeat_period = to_duration(kHeartbeat);
#else
  dds.reliable_writer_qos().times.heartbeatPeriod = to_duration(kHeartbeat);
#endif
  return dds;
}

}  // namespace

Reader::Reader(Participant& participant, const Endpoint& endpoint, Deliver deliver,
               Malformed on_malformed)
    : participant_{participant},
      topic_{participant, endpoint.topic, endpoint.type},
      dds_{participant.subscriber().create_datareader(
          topic_.dds(), reader_qos(participant, endpoint), nullptr, fdds::StatusMask::none())},
      deliver_{std::move(deliver)},
      on_malformed_{std::move(on_malformed)} {
  if (dds_ == nullptr)
    throw std::runtime_error("DDS refuses a subscription to " + ros_name(endpoint.topic));
  dds_->get_statuscondition().set_enabled_statuses(fdds::StatusMask::data_available());
}

Reader::~Reader() { participant_.subscriber().delete_datareader(dds_); }

int Reader::drain() {
  if (!waiting_ && !condition().get_trigger_value()) return 0;
  fdds::SampleInfo info;
  for (int taken = 0; taken < kBatch; ++taken) {
    if (closed_ || !ok(dds_->take_next_sample(&bytes_, &info))) {
      waiting_ = false;
      return taken;
    }
    if (info.valid_data) take_one(info);
  }
  waiting_ = true;  // take clears the status, so the wait set would not wake for the rest
  return kBatch;
}

void Reader::take_one(const fdds::SampleInfo& info) {
  if (deliver_(bytes_, info)) return;
  ++malformed_;
  on_malformed_(bytes_.size());
}

int Reader::matched() const {
  fdds::SubscriptionMatchedStatus status;
  dds_->get_subscription_matched_status(status);
  return status.current_count;
}

Writer::Writer(Participant& participant, const Endpoint& endpoint)
    : participant_{participant},
      name_{ros_name(endpoint.topic)},
      topic_{participant, endpoint.topic, endpoint.type},
      dds_{participant.publisher().create_datawriter(topic_.dds(),
                                                     writer_qos(participant, endpoint), &matches_,
                                                     fdds::StatusMask::publication_matched())} {
  if (dds_ == nullptr) throw std::runtime_error("DDS refuses a publisher of " + name_);
}

Writer::~Writer() {
  dds_->set_listener(nullptr);
  participant_.publisher().delete_datawriter(dds_);
}

bool Writer::write(const Bytes& bytes) { return ok(dds_->write(const_cast<Bytes*>(&bytes))); }

bool Writer::write(const Bytes& bytes, rtps::WriteParams& params) {
  return ok(dds_->write(const_cast<Bytes*>(&bytes), params));
}

int Writer::matched() const { return matches_.count(); }

bool Writer::reaches(const rtps::GUID_t& reader) const { return matches_.contains(reader); }

void Writer::Matches::on_publication_matched(fdds::DataWriter*,
                                             const fdds::PublicationMatchedStatus& status) {
  rtps::GUID_t reader;
  rtps::iHandle2GUID(reader, status.last_subscription_handle);
  const std::lock_guard lock{mutex_};
  if (status.current_count_change > 0)
    readers_.insert(reader);
  else
    readers_.erase(reader);
}

bool Writer::Matches::contains(const rtps::GUID_t& reader) const {
  const std::lock_guard lock{mutex_};
  return readers_.contains(reader);
}

int Writer::Matches::count() const {
  const std::lock_guard lock{mutex_};
  return static_cast<int>(readers_.size());
}

}  // namespace tandem::runtime
