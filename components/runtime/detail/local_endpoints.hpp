// SPDX-License-Identifier: Apache-2.0
// Publishers and subscriptions on a LocalBus. Private to runtime/.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tandem/runtime/detail/local_exchange.hpp"
#include "tandem/runtime/detail/ports.hpp"
#include "tandem/runtime/detail/sample.hpp"
#include "tandem/runtime/qos.hpp"

namespace tandem::runtime {

class LocalNode;

/// A subscription. As an event it delivers one message.
class LocalReader final : public SubscriptionPort,
                          public Event,
                          public std::enable_shared_from_this<LocalReader> {
 public:
  /// For messages of a type.
  LocalReader(LocalNode& node, std::string topic, const QoS& qos, Receiver receiver,
              Accepts accepts);
  /// For bytes of a type known only by name.
  LocalReader(LocalNode& node, std::string topic, std::string type, const QoS& qos,
              std::function<void(const std::vector<std::uint8_t>&)> fn);

  [[nodiscard]] int matched() const override { return matched_; }
  [[nodiscard]] PublisherId sender() const override { return sender_; }
  [[nodiscard]] std::uint64_t sequence() const override { return sequence_; }
  [[nodiscard]] long malformed() const override { return malformed_; }
  void may_wait(double) override {}
  void close() override;
  void run() override;

  [[nodiscard]] const std::string& topic() const { return topic_; }
  [[nodiscard]] const std::string& type() const { return type_; }
  [[nodiscard]] const QoS& qos() const { return qos_; }
  [[nodiscard]] bool accepts(const QoS& offered) const;
  /// Logs that it does not match a publisher of its topic.
  void report_mismatch(const QoS& offered) const;
  void count_match(int change) { matched_ += change; }

  /// Takes a message that has arrived; the oldest one gives way if there are too many.
  void push(std::shared_ptr<const Sample> sample);

 private:
  [[nodiscard]] bool call(const Sample& sample);

  LocalNode& node_;
  std::string topic_, type_;
  QoS qos_;
  Accepts accepts_;
  // Either of them. Shared with a callback that destroys the subscription.
  std::shared_ptr<const Receiver> receiver_;
  std::shared_ptr<const std::function<void(const std::vector<std::uint8_t>&)>> on_bytes_;
  std::deque<std::shared_ptr<const Sample>> queue_;
  PublisherId sender_{};
  std::uint64_t sequence_ = 0;
  long malformed_ = 0;
  int matched_ = 0;
  bool closed_ = false;
};

/// A publisher.
class LocalWriter final : public PublisherPort, public std::enable_shared_from_this<LocalWriter> {
 public:
  LocalWriter(LocalNode& node, std::string topic, TypeRef type, const QoS& qos);
  /// For bytes of a type known only by name.
  LocalWriter(LocalNode& node, std::string topic, std::string type, const QoS& qos);

  std::size_t publish(const void* message) override;
  std::size_t publish_bytes(const std::vector<std::uint8_t>& bytes) override;
  [[nodiscard]] int matched() const override { return static_cast<int>(links_.size()); }
  [[nodiscard]] PublisherId id() const override { return id_; }
  [[nodiscard]] const std::string& topic() const override { return topic_; }
  void close() override;

  [[nodiscard]] const std::string& type() const { return type_name_; }
  [[nodiscard]] const QoS& qos() const { return qos_; }
  void add(const std::shared_ptr<LocalReader>& reader);
  /// Whether the reader was matched.
  bool remove(const LocalReader& reader);

 private:
  struct Link {
    std::shared_ptr<LocalReader> reader;
    double last_arrival = 0.0;  // of a message sent on it [s]
  };
  void send(std::shared_ptr<Sample> sample);
  void send(Link& link, const std::shared_ptr<const Sample>& sample);

  LocalNode& node_;
  LocalExchange& exchange_;
  std::string topic_;
  TypeRef type_{};
  std::string type_name_;
  QoS qos_;
  PublisherId id_;
  std::uint64_t published_ = 0;
  std::vector<Link> links_;
  std::deque<std::shared_ptr<const Sample>> history_;  // if transient local
};

/// Connects the two if their QoS is compatible; otherwise the subscription logs why not.
void match(LocalWriter& writer, const std::shared_ptr<LocalReader>& reader);
void unmatch(LocalWriter& writer, LocalReader& reader);

}  // namespace tandem::runtime
