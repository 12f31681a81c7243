// SPDX-License-Identifier: Apache-2.0
#include "runtime/pubsub.hpp"

#include <algorithm>

#include "runtime/node_core.hpp"

namespace tandem::runtime {
namespace {

PublisherId id_of(const rtps::GUID_t& guid) {
  PublisherId id{};
  std::copy_n(guid.guidPrefix.value, guid.guidPrefix.size, id.begin());
  std::copy_n(guid.entityId.value, guid.entityId.size, id.begin() + guid.guidPrefix.size);
  return id;
}

}  // namespace

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
      fmt::format("{}: a message of {} bytes was not sent", writer_->topic(), size));
}

int AnyPublisher::matched() const { return writer_ ? writer_->matched() : 0; }

PublisherId AnyPublisher::id() const { return writer_ ? id_of(writer_->guid()) : PublisherId{}; }

void AnyPublisher::close() {
  if (writer_) node_->close_writer(*writer_);
  writer_.reset();
  node_.reset();
}

Subscription::Subscription(std::shared_ptr<NodeCore> node, std::shared_ptr<Reader> reader)
    : node_{std::move(node)}, reader_{std::move(reader)} {}

Subscription::~Subscription() { close(); }

Subscription& Subscription::operator=(Subscription&& other) noexcept {
  if (this == &other) return *this;
  close();
  node_ = std::move(other.node_);
  reader_ = std::move(other.reader_);
  return *this;
}

int Subscription::matched() const { return reader_ ? reader_->matched() : 0; }

PublisherId Subscription::sender() const {
  return reader_ ? id_of(reader_->sender()) : PublisherId{};
}

long Subscription::malformed() const { return reader_ ? reader_->malformed() : 0; }

void Subscription::close() {
  if (reader_) node_->close_reader(*reader_);
  reader_.reset();
  node_.reset();
}

}  // namespace tandem::runtime
