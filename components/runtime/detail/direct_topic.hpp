// SPDX-License-Identifier: Apache-2.0
// Carries messages between the nodes of one process on DDS without serializing them. Private to
// runtime/.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tandem/runtime/detail/sample.hpp"
#include "tandem/runtime/qos.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// The messages that wait for one reader. The oldest one gives way if there are more than the
/// reader's depth.
class TANDEM_EXPORT_FOR_TESTS DirectQueue {
 public:
  /// `on_arrival` is called on the publisher's thread after a message was added.
  DirectQueue(const QoS& qos, std::function<void()> on_arrival)
      : qos_{qos}, on_arrival_{std::move(on_arrival)} {}

  void push(std::shared_ptr<const Sample> sample);
  /// The oldest message; null if there is none.
  [[nodiscard]] std::shared_ptr<const Sample> pop();
  [[nodiscard]] bool is_empty() const { return is_empty_; }
  [[nodiscard]] const QoS& qos() const { return qos_; }

  /// Remembers a publisher whose messages come this way.
  void meet(const PublisherId& publisher);
  /// The publisher has gone. The last kMaxGone that have gone are still known.
  void part(const PublisherId& publisher);
  /// Whether the publisher's messages come, or came, this way, so that DDS's copies of them are
  /// duplicates.
  [[nodiscard]] bool knows(const PublisherId& publisher) const;

 private:
  static constexpr std::size_t kMaxGone = 64;

  QoS qos_;
  std::function<void()> on_arrival_;
  std::atomic<bool> is_empty_ = true;
  mutable std::mutex mutex_;  // guards what follows
  std::deque<std::shared_ptr<const Sample>> samples_;
  std::set<PublisherId> known_;
  std::deque<PublisherId> gone_;  // of the known ones
};

class DirectWriter;

/// The publishers and subscriptions of a topic under one of its types in this process.
/// Thread-safe.
class TANDEM_EXPORT_FOR_TESTS DirectTopic {
 public:
  void add(const std::shared_ptr<DirectQueue>& reader);
  /// Returns once no publisher is using it any more.
  void remove(const DirectQueue& reader);

 private:
  friend class DirectWriter;
  void match(DirectWriter& writer, const std::shared_ptr<DirectQueue>& reader);

  std::mutex mutex_;  // guards what follows and the writers' readers_
  std::vector<std::shared_ptr<DirectQueue>> readers_;
  std::vector<DirectWriter*> writers_;
};

/// The topics of a process. Thread-safe.
class TANDEM_EXPORT_FOR_TESTS DirectTopics {
 public:
  /// The topic of that name and type, which exists as long as anybody uses it.
  [[nodiscard]] std::shared_ptr<DirectTopic> of(const std::string& name, const std::string& type);

 private:
  std::mutex mutex_;
  std::map<std::pair<std::string, std::string>, std::weak_ptr<DirectTopic>> topics_;
};

/// A publisher of a volatile topic. What a transient local one publishes is kept by DDS for later
/// subscriptions, and goes to all of them through DDS.
class TANDEM_EXPORT_FOR_TESTS DirectWriter {
 public:
  DirectWriter(std::shared_ptr<DirectTopic> topic, const QoS& qos, const PublisherId& id);
  ~DirectWriter();
  DirectWriter(const DirectWriter&) = delete;
  DirectWriter& operator=(const DirectWriter&) = delete;

  /// Gives what `make` returns to the subscriptions that its QoS matches; `make` is called if there
  /// are any.
  void send(const std::function<std::shared_ptr<Sample>()>& make);

 private:
  friend class DirectTopic;

  std::shared_ptr<DirectTopic> topic_;
  Policies offered_;
  PublisherId id_;
  std::uint64_t published_ = 0;
  std::vector<std::shared_ptr<DirectQueue>> readers_;
};

}  // namespace tandem::runtime
