// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <msgs.hpp>

#include "tandem/runtime/qos.hpp"

namespace tandem::runtime {

/// A topic of the domain under one of its types, and what its endpoints offer and request.
struct TopicInfo {
  std::string name, type;  ///< "/cmd_vel", "geometry_msgs/msg/Twist"
  std::string type_hash;   ///< "RIHS01_…"; empty if no publisher tells it
  std::vector<Policies> publishers, subscriptions;
};

class Codec;
class NodeCore;
class ReaderSet;
class Writer;

/// Which publishers a subscription to a topic hears.
enum class Hears {
  kFitting,  ///< those that offer the topic's QoS
  kEvery,    ///< all: drivers of other makes publish it too, and may offer less
};

/// A topic: its name (ROS 2 form), its type, its QoS.
template <class M>
struct Topic {
  const char* name;
  QoS qos = kDefault;
  Hears hears = Hears::kFitting;
};

/// What the untyped side of the runtime knows about a message type.
struct TypeRef {
  const char* name;  ///< "geometry_msgs/msg/Twist"
  std::unique_ptr<eprosima::fastdds::dds::TopicDataType> (*create)();
};

template <class M>
[[nodiscard]] constexpr TypeRef type_ref() {
  return {MessageType<M>::name, &MessageType<M>::create};
}

/// A publisher, unique in its domain (its DDS GUID).
using PublisherId = std::array<std::uint8_t, 16>;

/// Sends messages of one type, of whatever type: the part of Publisher<M> that is no template.
class AnyPublisher {
 public:
  AnyPublisher() = default;
  AnyPublisher(std::shared_ptr<NodeCore> node, std::shared_ptr<Codec> codec,
               std::shared_ptr<Writer> writer);
  ~AnyPublisher();
  AnyPublisher(AnyPublisher&&) noexcept = default;
  AnyPublisher& operator=(AnyPublisher&& other) noexcept;

  void publish(const void* message) const;
  void publish_bytes(const std::vector<std::uint8_t>& bytes) const;
  [[nodiscard]] int matched() const;
  [[nodiscard]] PublisherId id() const;

 private:
  void close();
  void warn_not_sent(std::size_t size) const;

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<Codec> codec_;
  std::shared_ptr<Writer> writer_;
};

/// Sends messages to a topic until it is destroyed. Empty (default constructed): sends nothing.
template <class M>
class Publisher {
 public:
  Publisher() = default;
  explicit Publisher(AnyPublisher publisher) : publisher_{std::move(publisher)} {}

  /// Never blocks longer than 10 ms; a failure is logged once per second.
  void publish(const M& message) const { publisher_.publish(&message); }

  /// Subscriptions that receive it now.
  [[nodiscard]] int matched() const { return publisher_.matched(); }
  /// The id that Subscription::sender() returns for its messages; zeros if it is empty.
  [[nodiscard]] PublisherId id() const { return publisher_.id(); }

 private:
  AnyPublisher publisher_;
};

/// Sends bytes (plain CDR, encapsulation included) of a type that is known by name only.
class GenericPublisher {
 public:
  GenericPublisher() = default;
  explicit GenericPublisher(AnyPublisher publisher) : publisher_{std::move(publisher)} {}

  void publish(const std::vector<std::uint8_t>& bytes) const { publisher_.publish_bytes(bytes); }
  [[nodiscard]] int matched() const { return publisher_.matched(); }

 private:
  AnyPublisher publisher_;
};

/// Calls its function for each message of a topic until it is destroyed.
class Subscription {
 public:
  Subscription() = default;
  Subscription(std::shared_ptr<NodeCore> node, std::shared_ptr<ReaderSet> readers);
  ~Subscription();
  Subscription(Subscription&&) noexcept = default;
  Subscription& operator=(Subscription&& other) noexcept;

  /// Publishers that send to it now.
  [[nodiscard]] int matched() const;
  /// Who sent the last message.
  [[nodiscard]] PublisherId sender() const;
  /// The last message's number among those of its sender: 1, 2, …
  [[nodiscard]] std::uint64_t sequence() const;
  /// Samples dropped since the start because their bytes were no message of the type.
  [[nodiscard]] long malformed() const;

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<ReaderSet> readers_;
};

/// One reused message of a type and the function that wants it; what a Subscription needs of M.
struct Receiver {
  TypeRef type;
  std::function<void*()> message;  ///< where to decode to
  std::function<void()> reset;     ///< makes it anew after bytes that were no message
  std::function<void()> deliver;   ///< calls the function with it
};

/// False, never an exception, for bytes that are no message of the type (plain CDR).
[[nodiscard]] bool decode(const std::vector<std::uint8_t>& bytes, TypeRef type, void* message);

/// The message that the bytes (plain CDR, encapsulation included) are; nothing if they are none.
template <class M>
[[nodiscard]] std::optional<M> decode(const std::vector<std::uint8_t>& bytes) {
  M message;
  if (!decode(bytes, type_ref<M>(), &message)) return std::nullopt;
  return message;
}
/// The other way round; empty if it cannot be written.
[[nodiscard]] std::vector<std::uint8_t> encode(TypeRef type, const void* message);
template <class M>
[[nodiscard]] std::vector<std::uint8_t> encode(const M& message) {
  return encode(type_ref<M>(), &message);
}

template <class M, class Fn>
[[nodiscard]] Receiver make_receiver(Fn fn) {
  auto message = std::make_shared<M>();
  return {type_ref<M>(), [message]() -> void* { return message.get(); },
          [message] { *message = M{}; },
          [message, fn = std::function<void(const M&)>{std::move(fn)}] { fn(*message); }};
}

}  // namespace tandem::runtime
