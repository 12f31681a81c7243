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
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A topic of the domain under one of its types, and what its endpoints offer and request.
struct TopicInfo {
  std::string name, type;  ///< "/cmd_vel", "geometry_msgs/msg/Twist"
  std::string type_hash;   ///< "RIHS01_…"; empty if no publisher tells it
  std::vector<Policies> publishers, subscriptions;  ///< one for each endpoint
};

class NodeCore;
class PublisherPort;
class SubscriptionPort;

/// Which publishers a subscription matches.
enum class Accepts {
  kCompatible,  ///< those whose offer satisfies the topic's QoS
  kEvery,       ///< all: third-party publishers may offer weaker QoS
};

/// A topic: its name (ROS 2 form), its type, its QoS.
template <class M>
struct Topic {
  const char* name;    ///< relative to the node's namespace, unless it begins with / or ~
  QoS qos = kDefault;  ///< of both sides
  Accepts accepts = Accepts::kCompatible;  ///< of its subscriptions
};

/// What the untyped side of the runtime knows about a message type.
struct TypeRef {
  const char* name;  ///< "geometry_msgs/msg/Twist"
  std::unique_ptr<eprosima::fastdds::dds::TopicDataType> (*create)();  ///< makes DDS's type support
  std::shared_ptr<const void> (*copy)(const void* message);            ///< copies a message
};

/// The type of message M.
template <class M>
[[nodiscard]] constexpr TypeRef type_ref() {
  return {MessageType<M>::name, &MessageType<M>::create,
          [](const void* message) -> std::shared_ptr<const void> {
            return std::make_shared<const M>(*static_cast<const M*>(message));
          }};
}

/// A publisher's DDS GUID, unique in its domain.
using PublisherId = std::array<std::uint8_t, 16>;

/// Takes the QoS of all publishers of a topic; none are left if it is empty.
using PublishersChanged = std::function<void(const std::vector<Policies>& offered)>;

/// The type-erased part of `Publisher<M>`.
class TANDEM_EXPORT AnyPublisher {
 public:
  AnyPublisher() = default;
  /// Made by Node.
  AnyPublisher(std::shared_ptr<NodeCore> node, std::shared_ptr<PublisherPort> port);
  ~AnyPublisher();
  AnyPublisher(AnyPublisher&&) noexcept = default;
  AnyPublisher& operator=(AnyPublisher&& other) noexcept;

  /// As Publisher::publish(), for a message of the publisher's type.
  void publish(const void* message) const;
  /// Sends a serialized message.
  void publish_bytes(const std::vector<std::uint8_t>& bytes) const;
  /// Number of matched subscriptions.
  [[nodiscard]] int matched() const;
  /// As Publisher::id().
  [[nodiscard]] PublisherId id() const;

 private:
  void close();
  void warn_not_sent(std::size_t size) const;

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<PublisherPort> port_;
};

/// Publishes messages on a topic until it is destroyed. A default-constructed one sends nothing.
template <class M>
class Publisher {
 public:
  Publisher() = default;
  /// Made by Node::create_publisher().
  explicit Publisher(AnyPublisher publisher) : publisher_{std::move(publisher)} {}

  /// Never blocks longer than 10 ms; a failure is logged once per second.
  void publish(const M& message) const { publisher_.publish(&message); }

  /// Number of matched subscriptions.
  [[nodiscard]] int matched() const { return publisher_.matched(); }
  /// The id that Subscription::sender() returns for its messages; zeros if it is empty.
  [[nodiscard]] PublisherId id() const { return publisher_.id(); }

 private:
  AnyPublisher publisher_;
};

/// Publishes serialized messages (plain CDR, encapsulation included) of a type known only by name.
class GenericPublisher {
 public:
  GenericPublisher() = default;
  /// Made by Node::create_generic_publisher().
  explicit GenericPublisher(AnyPublisher publisher) : publisher_{std::move(publisher)} {}

  /// As Publisher::publish(), with the message in bytes.
  void publish(const std::vector<std::uint8_t>& bytes) const { publisher_.publish_bytes(bytes); }
  /// Number of matched subscriptions.
  [[nodiscard]] int matched() const { return publisher_.matched(); }

 private:
  AnyPublisher publisher_;
};

/// Calls its function for each message of a topic until it is destroyed.
class TANDEM_EXPORT Subscription {
 public:
  Subscription() = default;
  /// Made by Node::create_subscription().
  Subscription(std::shared_ptr<NodeCore> node, std::shared_ptr<SubscriptionPort> port);
  ~Subscription();
  Subscription(Subscription&&) noexcept = default;
  Subscription& operator=(Subscription&& other) noexcept;

  /// Number of matched publishers.
  [[nodiscard]] int matched() const;
  /// The publisher of the last message.
  [[nodiscard]] PublisherId sender() const;
  /// The last message's number among those of its sender: 1, 2, …
  [[nodiscard]] std::uint64_t sequence() const;
  /// Number of samples dropped so far because they failed to decode.
  [[nodiscard]] long malformed() const;

  /// From now on a message does not wake the node, but waits until it is awake for something else,
  /// at most `seconds`, and then comes before what woke it. Beyond the depth the oldest is lost. In
  /// the callback, Node::now() and stamp() are of the arrival, except under simulated time. What
  /// waits while the time jumps back is dropped. A LocalBus, where waking is free, ignores this.
  void may_wait(double seconds) const;

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<SubscriptionPort> port_;
};

/// A reused message and its callback: the type-erased part that a Subscription needs of M.
struct Receiver {
  TypeRef type;                                      ///< of the messages that it takes
  std::function<void*()> message;                    ///< where to decode to
  std::function<void()> reset;                       ///< clears it after a failed decode
  std::function<void(const void* message)> deliver;  ///< calls the function with a message
};

/// Decodes plain CDR. Returns false, and never throws, if the bytes are not a message of the type.
[[nodiscard]] TANDEM_EXPORT bool decode(const std::vector<std::uint8_t>& bytes, TypeRef type,
                                        void* message);

/// Decodes plain CDR with its encapsulation header; nullopt if the bytes are not a valid message.
template <class M>
[[nodiscard]] std::optional<M> decode(const std::vector<std::uint8_t>& bytes) {
  M message;
  if (!decode(bytes, type_ref<M>(), &message)) return std::nullopt;
  return message;
}
/// Encodes a message as plain CDR with its encapsulation header; empty if it cannot be encoded.
[[nodiscard]] TANDEM_EXPORT std::vector<std::uint8_t> encode(TypeRef type, const void* message);
template <class M>
[[nodiscard]] std::vector<std::uint8_t> encode(const M& message) {
  return encode(type_ref<M>(), &message);
}

/// A receiver that calls `fn` with a message of type M.
template <class M, class Fn>
[[nodiscard]] Receiver make_receiver(Fn fn) {
  auto message = std::make_shared<M>();
  return {type_ref<M>(), [message]() -> void* { return message.get(); },
          [message] { *message = M{}; },
          [fn = std::function<void(const M&)>{std::move(fn)}](const void* received) {
            fn(*static_cast<const M*>(received));
          }};
}

}  // namespace tandem::runtime
