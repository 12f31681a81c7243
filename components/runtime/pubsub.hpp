// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include <msgs.hpp>

#include "runtime/qos.hpp"

namespace tandem::runtime {

class Codec;
class NodeCore;
class Reader;
class Writer;

/// A topic: its name (ROS 2 form), its type, its QoS.
template <class M>
struct Topic {
  const char* name;
  QoS qos = kDefault;
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
  [[nodiscard]] int matched() const;

 private:
  void close();

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

 private:
  AnyPublisher publisher_;
};

/// Calls its function for each message of a topic until it is destroyed.
class Subscription {
 public:
  Subscription() = default;
  Subscription(std::shared_ptr<NodeCore> node, std::shared_ptr<Reader> reader);
  ~Subscription();
  Subscription(Subscription&&) noexcept = default;
  Subscription& operator=(Subscription&& other) noexcept;

  /// Publishers that send to it now.
  [[nodiscard]] int matched() const;
  /// Samples dropped since the start because their bytes were no message of the type.
  [[nodiscard]] long malformed() const;

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<Reader> reader_;
};

/// One reused message of a type and the function that wants it; what a Subscription needs of M.
struct Receiver {
  TypeRef type;
  std::function<void*()> message;  ///< where to decode to
  std::function<void()> reset;     ///< makes it anew after bytes that were no message
  std::function<void()> deliver;   ///< calls the function with it
};

template <class M, class Fn>
[[nodiscard]] Receiver make_receiver(Fn fn) {
  auto message = std::make_shared<M>();
  return {type_ref<M>(), [message]() -> void* { return message.get(); },
          [message] { *message = M{}; },
          [message, fn = std::function<void(const M&)>{std::move(fn)}] { fn(*message); }};
}

}  // namespace tandem::runtime
