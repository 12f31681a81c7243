// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/pubsub.hpp"

#include "tandem/runtime/detail/node_core.hpp"

namespace tandem::runtime {

AnyPublisher::AnyPublisher(std::shared_ptr<NodeCore> node, std::shared_ptr<PublisherPort> port)
    : node_{std::move(node)}, port_{std::move(port)} {}

AnyPublisher::~AnyPublisher() { close(); }

AnyPublisher& AnyPublisher::operator=(AnyPublisher&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  port_ = std::move(other.port_);
  return *this;
}

void AnyPublisher::publish(const void* message) const {
  if (!port_) return;
  if (const std::size_t size = port_->publish(message); size != 0) warn_not_sent(size);
}

void AnyPublisher::publish_bytes(const std::vector<std::uint8_t>& bytes) const {
  if (!port_) return;
  if (const std::size_t size = port_->publish_bytes(bytes); size != 0) warn_not_sent(size);
}

void AnyPublisher::warn_not_sent(std::size_t size) const {
  node_->log.write_every(
      1.0, LogLevel::kWarn, port_->topic(),
      fmt::format("{}: a message of {} bytes could not be sent", port_->topic(), size));
}

int AnyPublisher::matched() const { return port_ ? port_->matched() : 0; }

PublisherId AnyPublisher::id() const { return port_ ? port_->id() : PublisherId{}; }

void AnyPublisher::close() {
  if (port_) port_->close();
  port_.reset();
  node_.reset();
}

Subscription::Subscription(std::shared_ptr<NodeCore> node, std::shared_ptr<SubscriptionPort> port)
    : node_{std::move(node)}, port_{std::move(port)} {}

Subscription::~Subscription() { close(); }

Subscription& Subscription::operator=(Subscription&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  port_ = std::move(other.port_);
  return *this;
}

int Subscription::matched() const { return port_ ? port_->matched() : 0; }

PublisherId Subscription::sender() const { return port_ ? port_->sender() : PublisherId{}; }

std::uint64_t Subscription::sequence() const { return port_ ? port_->sequence() : 0; }

long Subscription::malformed() const { return port_ ? port_->malformed() : 0; }

void Subscription::may_wait(double seconds) const {
  if (port_) port_->may_wait(seconds);
}

void Subscription::close() {
  if (port_) port_->close();
  port_.reset();
  node_.reset();
}

}  // namespace tandem::runtime
