// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/direct_topic.hpp"

#include <utility>

#include "tandem/runtime/detail/wake_up.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {

void DirectQueue::push(std::shared_ptr<const Sample> sample) {
  {
    const std::lock_guard lock{mutex_};
    samples_.push_back(std::move(sample));
    if (std::ssize(samples_) > qos_.depth) samples_.pop_front();
    is_empty_ = samples_.empty();
  }
  on_arrival_();
}

std::shared_ptr<const Sample> DirectQueue::pop() {
  const std::lock_guard lock{mutex_};
  if (samples_.empty()) return nullptr;
  auto sample = std::move(samples_.front());
  samples_.pop_front();
  is_empty_ = samples_.empty();
  return sample;
}

void DirectQueue::meet(const PublisherId& publisher) {
  const std::lock_guard lock{mutex_};
  known_.insert(publisher);
}

void DirectQueue::part(const PublisherId& publisher) {
  const std::lock_guard lock{mutex_};
  gone_.push_back(publisher);
  if (gone_.size() <= kMaxGone) return;
  known_.erase(gone_.front());
  gone_.pop_front();
}

bool DirectQueue::knows(const PublisherId& publisher) const {
  const std::lock_guard lock{mutex_};
  return known_.contains(publisher);
}

void DirectTopic::add(const std::shared_ptr<DirectQueue>& reader) {
  const std::lock_guard lock{mutex_};
  readers_.push_back(reader);
  for (DirectWriter* writer : writers_) match(*writer, reader);
}

void DirectTopic::remove(const DirectQueue& reader) {
  const auto is_it = [&reader](const auto& queue) { return queue.get() == &reader; };
  const std::lock_guard lock{mutex_};
  std::erase_if(readers_, is_it);
  for (DirectWriter* writer : writers_) std::erase_if(writer->readers_, is_it);
}

void DirectTopic::match(DirectWriter& writer, const std::shared_ptr<DirectQueue>& reader) {
  if (!qos_mismatches(writer.offered_, policies_of(reader->qos())).empty()) return;
  reader->meet(writer.id_);
  writer.readers_.push_back(reader);
}

std::shared_ptr<DirectTopic> DirectTopics::of(const std::string& name, const std::string& type) {
  const std::lock_guard lock{mutex_};
  std::erase_if(topics_, [](const auto& entry) { return entry.second.expired(); });
  auto& known = topics_[{name, type}];
  auto found = known.lock();
  if (!found) known = found = std::make_shared<DirectTopic>();
  return found;
}

DirectWriter::DirectWriter(std::shared_ptr<DirectTopic> topic, const QoS& qos,
                           const PublisherId& id)
    : topic_{std::move(topic)}, offered_{policies_of(qos)}, id_{id} {
  const std::lock_guard lock{topic_->mutex_};
  topic_->writers_.push_back(this);
  for (const auto& reader : topic_->readers_) topic_->match(*this, reader);
}

DirectWriter::~DirectWriter() {
  const std::lock_guard lock{topic_->mutex_};
  std::erase(topic_->writers_, this);
  for (const auto& reader : readers_) reader->part(id_);
}

// The lock is held until the last reader has the message, so that one that is removed is not used
// any more.
void DirectWriter::send(const std::function<std::shared_ptr<Sample>()>& make) {
  const WakeUp::Deferral until_all_have_it;
  const std::lock_guard lock{topic_->mutex_};
  if (readers_.empty()) return;
  const auto sample = make();
  sample->sender = id_;
  sample->number = ++published_;
  sample->published = steady_seconds();
  for (const auto& reader : readers_) reader->push(sample);
}

}  // namespace tandem::runtime
