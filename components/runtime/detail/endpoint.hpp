// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: readers and writers of bytes, with ROS 2's QoS.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/detail/participant.hpp"
#include "tandem/runtime/detail/transit.hpp"
#include "tandem/runtime/qos.hpp"

namespace tandem::runtime {

/// Where an endpoint is: DDS names of topic and type, QoS.
struct Endpoint {
  std::string topic;
  std::string type;
  QoS qos;
  std::string type_hash{};  ///< if empty: the one that the IDL gives
  std::string
      parameter{};  ///< "qos_overrides./odom.subscription"; empty: nothing overrides its QoS

  /// What ROS 2 from Iron on reads in USER_DATA: "typehash=RIHS01_…;". Humble knows no hashes.
  [[nodiscard]] std::string user_data(bool humble) const;
};

/// Takes the samples of a topic as bytes.
class Reader {
 public:
  /// False for bytes that are no message of the type.
  using Deliver = std::function<bool(const Bytes&, const fdds::SampleInfo&)>;
  /// Of samples that are not delivered.
  struct Refused {
    std::function<void(std::size_t size)> malformed;
    std::function<void()> late;
  };

  Reader(Participant& participant, const Endpoint& endpoint, Deliver deliver, Refused refused);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// Delivers what has arrived, but at most one batch (the rest is `waiting`); how many it took.
  int drain();
  [[nodiscard]] bool waiting() const { return waiting_; }
  void close() { closed_ = true; }  ///< stops delivery

  [[nodiscard]] fdds::Condition& condition() { return dds_->get_statuscondition(); }
  [[nodiscard]] rtps::GUID_t guid() const { return dds_->guid(); }
  [[nodiscard]] Participant& participant() const { return topic_.participant(); }
  [[nodiscard]] int matched() const;
  [[nodiscard]] long malformed() const { return malformed_; }

 private:
  void take_one(const fdds::SampleInfo& info);
  [[nodiscard]] bool is_late(const fdds::SampleInfo& info);

  SharedTopic topic_;
  fdds::DataReader* dds_;
  Deliver deliver_;
  Refused refused_;
  double lifespan_;                          // [s]
  std::map<rtps::GUID_t, Transit> transit_;  // by writer
  Bytes bytes_;                              // reused
  rtps::GUID_t sender_;
  std::atomic<long> malformed_ = 0;
  bool waiting_ = true;  // look once: data may have come before the wait set watched
  bool closed_ = false;
};

/// Writes bytes to a topic.
class Writer {
 public:
  Writer(Participant& participant, const Endpoint& endpoint);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  [[nodiscard]] bool write(const Bytes& bytes);
  [[nodiscard]] bool write(const Bytes& bytes, rtps::WriteParams& params);

  [[nodiscard]] rtps::GUID_t guid() const { return dds_->guid(); }
  [[nodiscard]] Participant& participant() const { return topic_.participant(); }
  [[nodiscard]] int matched() const;
  /// Grows with every reader that was matched, first 1.
  using Turn = std::uint64_t;
  /// When that reader was matched; of a writer's GUID: the latest reader of its participant (a
  /// client that is not rmw_fastrtps gives its writer only). 0: not matched.
  [[nodiscard]] Turn matched_at(const rtps::GUID_t& peer) const;
  [[nodiscard]] const std::string& topic() const { return name_; }

 private:
  // Only keeps the list that get_matched_subscriptions() of 2.9.1 does not give.
  class Matches final : public fdds::DataWriterListener {
   public:
    void on_publication_matched(fdds::DataWriter*,
                                const fdds::PublicationMatchedStatus& status) override;
    [[nodiscard]] Turn of(const rtps::GUID_t& reader) const;
    [[nodiscard]] Turn latest_of(const rtps::GuidPrefix_t& participant) const;
    [[nodiscard]] int count() const;

   private:
    mutable std::mutex mutex_;
    std::map<rtps::GUID_t, Turn> readers_;
    Turn turn_ = 0;
  };

  std::string name_;
  SharedTopic topic_;
  Matches matches_;
  fdds::DataWriter* dds_;
};

}  // namespace tandem::runtime
