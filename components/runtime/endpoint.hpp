// SPDX-License-Identifier: Apache-2.0
// Private to runtime/: readers and writers of bytes, with ROS 2's QoS.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "runtime/dds.hpp"
#include "runtime/participant.hpp"
#include "runtime/qos.hpp"

namespace tandem::runtime {

/// Where an endpoint is: DDS names of topic and type, QoS.
struct Endpoint {
  std::string topic;
  std::string type;
  QoS qos;
};

/// Takes the samples of a topic as bytes.
class Reader {
 public:
  /// False for bytes that are no message of the type.
  using Deliver = std::function<bool(const Bytes&, const fdds::SampleInfo&)>;
  using Malformed = std::function<void(std::size_t size)>;

  Reader(Participant& participant, const Endpoint& endpoint, Deliver deliver,
         Malformed on_malformed);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// Delivers what has arrived, but at most one batch (the rest is `waiting`); how many it took.
  int drain();
  [[nodiscard]] bool waiting() const { return waiting_; }
  void close() { closed_ = true; }  ///< nothing is delivered any more

  [[nodiscard]] fdds::Condition& condition() { return dds_->get_statuscondition(); }
  [[nodiscard]] rtps::GUID_t guid() const { return dds_->guid(); }
  [[nodiscard]] int matched() const;
  [[nodiscard]] long malformed() const { return malformed_; }

 private:
  void take_one(const fdds::SampleInfo& info);

  Participant& participant_;
  SharedTopic topic_;
  fdds::DataReader* dds_;
  Deliver deliver_;
  Malformed on_malformed_;
  Bytes bytes_;  // reused
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
  [[nodiscard]] int matched() const;
  /// True while the reader with that GUID receives what is written.
  [[nodiscard]] bool reaches(const rtps::GUID_t& reader) const;
  [[nodiscard]] const std::string& topic() const { return name_; }

 private:
  // Only keeps the list that get_matched_subscriptions() of 2.9.1 does not give.
  class Matches final : public fdds::DataWriterListener {
   public:
    void on_publication_matched(fdds::DataWriter*,
                                const fdds::PublicationMatchedStatus& status) override;
    [[nodiscard]] bool contains(const rtps::GUID_t& reader) const;
    [[nodiscard]] int count() const;

   private:
    mutable std::mutex mutex_;
    std::set<rtps::GUID_t> readers_;
  };

  Participant& participant_;
  std::string name_;
  SharedTopic topic_;
  Matches matches_;
  fdds::DataWriter* dds_;
};

}  // namespace tandem::runtime
