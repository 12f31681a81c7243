// SPDX-License-Identifier: Apache-2.0
// The interfaces between a node's handles and the bus that carries their messages; dds_node.* and
// local_node.* implement them. Private to runtime/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/service.hpp"

namespace tandem::runtime {

/// Sends the messages of one publisher. Thread-safe on DDS.
class PublisherPort {
 public:
  virtual ~PublisherPort() = default;
  /// Sends a message of the publisher's type. Returns 0, or the size [bytes] of a message that
  /// could not be sent.
  [[nodiscard]] virtual std::size_t publish(const void* message) = 0;
  /// The same for a serialized message.
  [[nodiscard]] virtual std::size_t publish_bytes(const std::vector<std::uint8_t>& bytes) = 0;
  [[nodiscard]] virtual int matched() const = 0;
  [[nodiscard]] virtual PublisherId id() const = 0;
  [[nodiscard]] virtual const std::string& topic() const = 0;  ///< full name
  virtual void close() = 0;
};

/// Receives the messages of one subscription.
class SubscriptionPort {
 public:
  virtual ~SubscriptionPort() = default;
  [[nodiscard]] virtual int matched() const = 0;
  [[nodiscard]] virtual PublisherId sender() const = 0;
  [[nodiscard]] virtual std::uint64_t sequence() const = 0;
  [[nodiscard]] virtual long malformed() const = 0;
  /// As Subscription::may_wait().
  virtual void may_wait(double seconds) = 0;
  virtual void close() = 0;
};

/// Answers the requests of one service.
class ServicePort {
 public:
  virtual ~ServicePort() = default;
  virtual void close() = 0;
};

/// Sends the requests of one client.
class ClientPort {
 public:
  virtual ~ClientPort() = default;
  /// As Client::call(), for messages of the service's types.
  virtual void call(const void* request, Receiver response, double timeout,
                    std::function<void()> on_timeout) = 0;
  /// The same for serialized messages.
  virtual void call_bytes(const std::vector<std::uint8_t>& request,
                          std::function<void(const std::vector<std::uint8_t>&)> fn, double timeout,
                          std::function<void()> on_timeout) = 0;
  [[nodiscard]] virtual bool ready() const = 0;
  virtual void close() = 0;
};

/// Runs the work of one Worker.
class WorkerPort {
 public:
  virtual ~WorkerPort() = default;
  virtual void wake() = 0;
  /// Returns once no work is running any more.
  virtual void close() = 0;
};

}  // namespace tandem::runtime
