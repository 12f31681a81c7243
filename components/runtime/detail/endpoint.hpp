// SPDX-License-Identifier: Apache-2.0
// Provides DDS readers and writers of serialized samples with ROS 2's QoS. Private to runtime/.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/detail/direct_topic.hpp"
#include "tandem/runtime/detail/participant.hpp"
#include "tandem/runtime/detail/transit.hpp"
#include "tandem/runtime/qos.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Topic and type (DDS names) and QoS of a reader or writer.
struct Endpoint {
  std::string topic;
  std::string type;
  QoS qos;
  std::string type_hash{};  ///< if empty, the hash from idl/
  /// Prefix of the QoS parameters, "qos_overrides./odom.subscription"; empty if there are none.
  std::string parameter{};

  /// The USER_DATA that ROS 2 reads from Iron on, "typehash=RIHS01_…;". Humble has no type hashes.
  [[nodiscard]] std::string user_data(bool humble) const;
  /// The endpoint as discovery lists it.
  [[nodiscard]] KnownEndpoint known(const rtps::GUID_t& guid, bool writes,
                                    const Participant& participant) const;
  /// Why a sample was dropped, for the log.
  [[nodiscard]] std::string malformed_text(std::size_t size) const;
  [[nodiscard]] std::string late_text() const;
};

[[nodiscard]] PublisherId to_id(const rtps::GUID_t& guid);
[[nodiscard]] rtps::GUID_t to_guid(const PublisherId& id);

/// Receives the samples of a topic as bytes.
class TANDEM_EXPORT_FOR_TESTS Reader {
 public:
  /// Returns false for bytes that are not a valid message of the type.
  using Deliver = std::function<bool(const Bytes&, const fdds::SampleInfo&)>;
  /// The same for a message of this process.
  using DeliverSample = std::function<bool(const Sample&)>;
  /// Callbacks for samples that are not delivered.
  struct Refused {
    std::function<void(std::size_t size)> malformed;
    std::function<void()> late;
  };

  Reader(Participant& participant, const Endpoint& endpoint, Deliver deliver, Refused refused);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// Has the messages of this process's publishers come through `topic`, as they are. Before
  /// on_arrival().
  void receive_directly(std::shared_ptr<DirectTopic> topic, DeliverSample deliver);
  /// Calls `fn` from now on when DDS brings a sample, on the thread that brings it; `fn` may call
  /// drain_bytes(). Calls `direct`, or `fn` if it is empty, when a publisher of this process brings
  /// one, on the publisher's thread, one call at a time; `direct` may call drain_samples().
  void on_arrival(std::function<void()> fn, std::function<void()> direct = {});

  /// Delivers at most one batch each of what DDS and this process have brought, and returns how
  /// many were taken. waiting() is true if more may be left.
  int drain() {
    const int samples = drain_samples();
    return samples + drain_bytes();
  }
  int drain_samples();  ///< of this process
  int drain_bytes();    ///< of DDS
  [[nodiscard]] bool waiting() const {
    return waiting_ || (patience_ > 0.0 ? samples_left_ : has_samples());
  }
  /// Whether drain() has anything to do.
  [[nodiscard]] bool is_due() const { return has_samples() || has_bytes(); }
  void close();  ///< stops delivery

  /// How long what arrives may wait [s] for a drain(); 0, the default: not at all.
  void set_patience(double seconds) { patience_ = seconds; }
  [[nodiscard]] double patience() const { return patience_; }

  [[nodiscard]] rtps::GUID_t guid() const { return dds_->guid(); }
  [[nodiscard]] Participant& participant() const { return topic_.participant(); }
  [[nodiscard]] int matched() const;
  [[nodiscard]] long malformed() const { return malformed_; }

 private:
  class Arrival final : public fdds::DataReaderListener {
   public:
    void on_data_available(fdds::DataReader*) override {
      any = true;
      fn();
    }
    std::function<void()> fn;
    std::atomic<bool> any = false;  // since the last drain()
  };

  void take_one(const Sample& sample);
  void take_one(const fdds::SampleInfo& info);
  [[nodiscard]] bool has_samples() const { return queue_ && !queue_->is_empty(); }
  [[nodiscard]] bool has_bytes() const;
  [[nodiscard]] bool is_late(const fdds::SampleInfo& info);

  SharedTopic topic_;
  Arrival arrival_;
  fdds::DataReader* dds_;
  Deliver deliver_;
  DeliverSample deliver_sample_;
  std::function<void()> direct_arrival_;
  std::shared_ptr<DirectTopic> direct_topic_;
  std::shared_ptr<DirectQueue> queue_;  // null unless it receives directly
  Refused refused_;
  QoS qos_;
  std::map<rtps::GUID_t, Transit> transit_;  // key: writer
  Bytes bytes_;                              // reused
  rtps::GUID_t sender_;
  std::atomic<long> malformed_ = 0;
  bool waiting_ = true;  // DDS may have brought something before on_arrival(), or more than a batch
  bool samples_left_ = false;  // there was more than a batch
  std::atomic<bool> closed_ = false;
  std::atomic<double> patience_ = 0.0;
};

/// Writes bytes to a topic.
class TANDEM_EXPORT_FOR_TESTS Writer {
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
  /// Whether readers of other participants are matched, which messages reach only through DDS.
  [[nodiscard]] bool is_read_elsewhere() const { return matches_.has_others_than(guid()); }
  /// Order in which readers were matched, starting at 1.
  using Turn = std::uint64_t;
  /// The turn of the given reader or, for a writer's GUID, of the latest matched reader of its
  /// participant (clients other than rmw_fastrtps send only their writer's GUID). 0 if not matched.
  [[nodiscard]] Turn matched_at(const rtps::GUID_t& peer) const;
  [[nodiscard]] const std::string& topic() const { return name_; }

 private:
  // Lists the matched readers, because get_matched_subscriptions() of Fast DDS 2.9.1 does not.
  class Matches final : public fdds::DataWriterListener {
   public:
    void on_publication_matched(fdds::DataWriter*,
                                const fdds::PublicationMatchedStatus& status) override;
    [[nodiscard]] Turn of(const rtps::GUID_t& reader) const;
    [[nodiscard]] Turn latest_of(const rtps::GuidPrefix_t& participant) const;
    [[nodiscard]] int count() const;
    [[nodiscard]] bool has_others_than(const rtps::GUID_t& writer) const;

   private:
    mutable std::mutex mutex_;
    std::map<rtps::GUID_t, Turn> readers_;
    std::int64_t count_of_dds_ = 0;
    bool is_doubtful_ = false;  // readers_ may lack one
    Turn turn_ = 0;
  };

  std::string name_;
  SharedTopic topic_;
  Matches matches_;
  fdds::DataWriter* dds_;
};

}  // namespace tandem::runtime
