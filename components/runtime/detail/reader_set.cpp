// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/reader_set.hpp"

#include <algorithm>
#include <utility>

#include "tandem/runtime/detail/dds_node.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem::runtime {
namespace {

// Since it was received [s].
double waited(const fdds::SampleInfo& info) {
  return 1e-9 * static_cast<double>(system_nanoseconds() - info.reception_timestamp.to_ns());
}

int strength(const Policies& requested) { return requested.reliability + requested.durability; }

// Index of the most demanding reader compatible with the publisher; requested.size() if none is.
std::size_t strongest_fit(const std::vector<Policies>& requested, const Policies& offered) {
  std::size_t best = requested.size();
  for (std::size_t i = 0; i < requested.size(); ++i) {
    if (!qos_mismatches(offered, requested[i]).empty()) continue;
    if (best == requested.size() || strength(requested[i]) > strength(requested[best])) best = i;
  }
  return best;
}

}  // namespace

ReaderSet::ReaderSet(DdsNode& node, Endpoint endpoint, Reader::Deliver deliver,
                     Reader::DeliverSample deliver_sample)
    : node_{node},
      endpoint_{std::move(endpoint)},
      route_{std::make_shared<Route>(
          Route{node.discovery(), std::move(deliver), std::move(deliver_sample), {}, {}})} {
  open(endpoint_.qos);
}

// Whether the reader with this index delivers what the publisher sent.
bool ReaderSet::Route::takes(std::size_t index, const rtps::GUID_t& publisher,
                             std::uint64_t number) {
  if (requested.size() > 1) {
    const auto offered = discovery.policies(publisher);  // unknown for a publisher that has left
    if (offered && strongest_fit(requested, *offered) != index) return false;
  }
  sender = publisher;
  sequence = number;
  return true;
}

void ReaderSet::open(const QoS& qos) {
  const std::size_t index = readers_.size();
  auto deliver = [&node = node_, route = route_, index](const Bytes& bytes, const auto& info) {
    const auto& identity = info.sample_identity;
    if (!route->takes(index, identity.writer_guid(), identity.sequence_number().to64long()))
      return true;
    return node.at_arrival(waited(info), route->patience,
                           [&] { return route->deliver(bytes, info); });
  };
  auto deliver_sample = [&node = node_, route = route_, index](const Sample& sample) {
    if (!route->takes(index, to_guid(sample.sender), sample.number)) return true;
    return node.at_arrival(steady_seconds() - sample.published, route->patience,
                           [&] { return route->deliver_sample(sample); });
  };
  Endpoint endpoint = endpoint_;
  endpoint.qos = qos;
  route_->requested.push_back(policies_of(qos));
  readers_.push_back(node_.open_reader(endpoint, std::move(deliver), std::move(deliver_sample)));
  readers_.back()->set_patience(route_->patience);
  node_.update_patience();
}

void ReaderSet::may_wait(double seconds) {
  route_->patience = std::max(0.0, seconds);
  for (const auto& reader : readers_) reader->set_patience(route_->patience);
  node_.update_patience();
}

void ReaderSet::accept_every_publisher(std::function<QoS(const QoS&)> tuned) {
  publishers_wanted_ = node_.peers().watch_publishers(
      endpoint_.topic, endpoint_.type, [this, tuned = std::move(tuned)](const auto& publishers) {
        for (const Policies& publisher : publishers) open_for(publisher, tuned);
      });
}

// Additional readers are volatile, so that each matches every publisher that a more demanding
// reader matches. Parameters may rule out a compatible QoS; PeerWatch then reports the mismatch.
void ReaderSet::open_for(const Policies& publisher, const std::function<QoS(const QoS&)>& tuned) {
  if (qos_mismatches(publisher, route_->requested.front()).empty()) return;
  QoS weaker = endpoint_.qos;
  weaker.durability = Durability::kVolatile;
  if (publisher.reliability < 1) weaker.reliability = Reliability::kBestEffort;
  const QoS qos = tuned(weaker);
  const Policies wanted = policies_of(qos);
  const bool is_open = std::any_of(
      route_->requested.begin(), route_->requested.end(),
      [&](const Policies& requested) { return strength(requested) == strength(wanted); });
  if (!is_open && qos_mismatches(publisher, wanted).empty()) open(qos);
}

void ReaderSet::close() {
  publishers_wanted_.reset();
  for (const auto& reader : readers_) node_.close_reader(*reader);
  readers_.clear();
}

// The least demanding reader matches every publisher that the others match.
int ReaderSet::matched() const {
  int most = 0;
  for (const auto& reader : readers_) most = std::max(most, reader->matched());
  return most;
}

long ReaderSet::malformed() const {
  long all = 0;
  for (const auto& reader : readers_) all += reader->malformed();
  return all;
}

}  // namespace tandem::runtime
