// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/local_endpoints.hpp"

#include <algorithm>
#include <utility>

#include "tandem/runtime/detail/local_node.hpp"

namespace tandem::runtime {
namespace {

// A message on its way.
class Arrival final : public Event {
 public:
  Arrival(std::shared_ptr<LocalReader> reader, std::shared_ptr<const Sample> sample)
      : reader_{std::move(reader)}, sample_{std::move(sample)} {}
  void run() override { reader_->push(std::move(sample_)); }

 private:
  std::shared_ptr<LocalReader> reader_;
  std::shared_ptr<const Sample> sample_;
};

bool is_latched(const QoS& qos) { return qos.durability == Durability::kTransientLocal; }

}  // namespace

LocalReader::LocalReader(LocalNode& node, std::string topic, const QoS& qos, Receiver receiver,
                         Accepts accepts)
    : node_{node},
      topic_{std::move(topic)},
      type_{receiver.type.name},
      qos_{qos},
      accepts_{accepts},
      receiver_{std::make_shared<const Receiver>(std::move(receiver))} {}

LocalReader::LocalReader(LocalNode& node, std::string topic, std::string type, const QoS& qos,
                         std::function<void(const std::vector<std::uint8_t>&)> fn)
    : node_{node},
      topic_{std::move(topic)},
      type_{std::move(type)},
      qos_{qos},
      accepts_{Accepts::kCompatible},
      on_bytes_{std::make_shared<const std::function<void(const std::vector<std::uint8_t>&)>>(
          std::move(fn))} {}

void LocalReader::close() {
  closed_ = true;
  queue_.clear();
  node_.exchange().close(*this);
}

bool LocalReader::accepts(const QoS& offered) const {
  return accepts_ == Accepts::kEvery ||
         qos_mismatches(policies_of(offered), policies_of(qos_)).empty();
}

void LocalReader::report_mismatch(const QoS& offered) const {
  for (const QosMismatch& mismatch : qos_mismatches(policies_of(offered), policies_of(qos_)))
    node_.log.warn("{}: no messages from a publisher that offers {} {}; this node requests {}",
                   topic_, mismatch.policy, mismatch.offered, mismatch.requested);
}

void LocalReader::push(std::shared_ptr<const Sample> sample) {
  if (closed_) return;
  queue_.push_back(std::move(sample));
  if (std::ssize(queue_) > qos_.depth)
    queue_.pop_front();  // the event of the message that was dropped delivers this one
  else
    node_.exchange().events().post(shared_from_this());
}

void LocalReader::run() {
  if (queue_.empty()) return;
  const auto sample = std::move(queue_.front());
  queue_.pop_front();
  if (closed_ || node_.stopped()) return;
  if (node_.steady_now() > sample->published + qos_.lifespan) return;
  sender_ = sample->sender;
  sequence_ = sample->number;
  node_.exchange().count_delivery();
  const LocalNode::Running running{node_};
  if (!call(*sample)) ++malformed_;
}

bool LocalReader::call(const Sample& sample) {
  if (const auto on_bytes = on_bytes_) {
    if (sample.bytes().empty()) return false;  // it is too large for its type
    (*on_bytes)(sample.bytes());
    return true;
  }
  const auto receiver = receiver_;
  return deliver(sample, *receiver);
}

LocalWriter::LocalWriter(LocalNode& node, std::string topic, TypeRef type, const QoS& qos)
    : LocalWriter{node, std::move(topic), std::string{type.name}, qos} {
  type_ = type;
}

LocalWriter::LocalWriter(LocalNode& node, std::string topic, std::string type, const QoS& qos)
    : node_{node},
      exchange_{node.exchange()},
      topic_{std::move(topic)},
      type_name_{std::move(type)},
      qos_{qos},
      id_{exchange_.new_id()} {}

void LocalWriter::close() {
  exchange_.close(*this);
  links_.clear();
  history_.clear();
}

std::size_t LocalWriter::publish(const void* message) {
  ++published_;
  if (!links_.empty() || is_latched(qos_))
    send(std::make_shared<Sample>(type_, type_.copy(message)));
  return 0;
}

std::size_t LocalWriter::publish_bytes(const std::vector<std::uint8_t>& bytes) {
  ++published_;
  if (!links_.empty() || is_latched(qos_)) send(std::make_shared<Sample>(bytes));
  return 0;
}

void LocalWriter::send(std::shared_ptr<Sample> sample) {
  sample->sender = id_;
  sample->number = published_;
  sample->published = node_.steady_now();
  if (is_latched(qos_)) {
    history_.push_back(sample);
    if (std::ssize(history_) > qos_.depth) history_.pop_front();
  }
  for (Link& link : links_) send(link, sample);
}

void LocalWriter::send(Link& link, const std::shared_ptr<const Sample>& sample) {
  const LinkFaults& faults = exchange_.faults_of(topic_);
  const bool is_reliable = link.reader->qos().reliability == Reliability::kReliable &&
                           qos_.reliability == Reliability::kReliable;
  const double now = exchange_.events().now();
  double arrival = now + faults.delay;
  if (faults.jitter > 0.0) arrival += faults.jitter * exchange_.draw();
  if (faults.loss > 0.0) {
    bool is_lost = exchange_.draw() < faults.loss;
    if (is_lost && (!is_reliable || faults.loss == 1.0)) return;
    for (; is_lost; is_lost = exchange_.draw() < faults.loss) arrival += LocalBus::kResend;
  }
  if (arrival < link.last_arrival && !is_reliable) return;  // overtaken
  arrival = link.last_arrival = std::max(arrival, link.last_arrival);
  if (arrival <= now)
    link.reader->push(sample);
  else
    exchange_.events().post_at(arrival, EventQueue::Rank::kMessage,
                               std::make_shared<Arrival>(link.reader, sample));
}

void LocalWriter::add(const std::shared_ptr<LocalReader>& reader) {
  Link& link = links_.emplace_back(Link{reader});
  if (!is_latched(reader->qos())) return;
  const auto depth = static_cast<std::size_t>(reader->qos().depth);
  const std::size_t first = history_.size() > depth ? history_.size() - depth : 0;
  for (std::size_t i = first; i < history_.size(); ++i) send(link, history_[i]);
}

bool LocalWriter::remove(const LocalReader& reader) {
  return std::erase_if(links_, [&](const Link& link) { return link.reader.get() == &reader; }) > 0;
}

void match(LocalWriter& writer, const std::shared_ptr<LocalReader>& reader) {
  if (!reader->accepts(writer.qos())) return reader->report_mismatch(writer.qos());
  reader->count_match(1);
  writer.add(reader);
}

void unmatch(LocalWriter& writer, LocalReader& reader) {
  if (writer.remove(reader)) reader.count_match(-1);
}

}  // namespace tandem::runtime
