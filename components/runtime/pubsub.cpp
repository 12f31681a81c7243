// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/pubsub.hpp"

#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/detail/reader_set.hpp"

namespace tandem::runtime {

AnyPublisher::AnyPublisher(std::shared_ptr<NodeCore> node, std::shared_ptr<Codec> codec,
                           std::shared_ptr<Writer> writer)
    : node_{std::move(node)}, codec_{std::move(codec)}, writer_{std::move(writer)} {}

AnyPublisher::~AnyPublisher() { close(); }

AnyPublisher& AnyPublisher::operator=(AnyPublisher&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  codec_ = std::move(other.codec_);
  writer_ = std::move(other.writer_);
  return *this;
}

void AnyPublisher::publish(const void* message) const {
  if (!writer_) return;
  thread_local Bytes bytes;  // reused by all publishers of this thread
  if (codec_->encode(message, bytes))
    publish_bytes(bytes);
  else
    warn_not_sent(bytes.size());
}

void AnyPublisher::publish_bytes(const Bytes& bytes) const {
  if (writer_ && !writer_->write(bytes)) warn_not_sent(bytes.size());
}

void AnyPublisher::warn_not_sent(std::size_t size) const {
  node_->log.write_every(
      1.0, LogLevel::kWarn, writer_->topic(),
      fmt::format("{}: a message of {} bytes could not be sent", writer_->topic(), size));
}

int AnyPublisher::matched() const { return writer_ ? writer_->matched() : 0; }

PublisherId AnyPublisher::id() const { return writer_ ? to_id(writer_->guid()) : PublisherId{}; }

void AnyPublisher::close() {
  if (writer_) node_->close_writer(*writer_);
  writer_.reset();
  node_.reset();
}

Subscription::Subscription(std::shared_ptr<NodeCore> node, std::shared_ptr<ReaderSet> readers)
    : node_{std::move(node)}, readers_{std::move(readers)} {}

Subscription::~Subscription() { close(); }

Subscription& Subscription::operator=(Subscription&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  readers_ = std::move(other.readers_);
  return *this;
}

int Subscription::matched() const { return readers_ ? readers_->matched() : 0; }

PublisherId Subscription::sender() const { return readers_ ? readers_->sender() : PublisherId{}; }

std::uint64_t Subscription::sequence() const { return readers_ ? readers_->sequence() : 0; }

long Subscription::malformed() const { return readers_ ? readers_->malformed() : 0; }

void Subscription::close() {
  if (readers_) readers_->close();
  readers_.reset();
  node_.reset();
}

}  // namespace tandem::runtime
