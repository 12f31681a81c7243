// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/reader_set.hpp"

#include <algorithm>
#include <utility>

#include "tandem/runtime/detail/dds_node.hpp"

namespace tandem::runtime {
namespace {

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

PublisherId to_id(const rtps::GUID_t& guid) {
  PublisherId id{};
  const auto& [prefix, entity] = guid;
  std::copy_n(entity.value, entity.size, std::copy_n(prefix.value, prefix.size, id.begin()));
  return id;
}

rtps::GUID_t to_guid(const PublisherId& id) {
  rtps::GUID_t guid;
  const auto entity = id.begin() + guid.guidPrefix.size;
  std::copy(id.begin(), entity, guid.guidPrefix.value);
  std::copy(entity, id.end(), guid.entityId.value);
  return guid;
}

ReaderSet::ReaderSet(DdsNode& node, Endpoint endpoint, Reader::Deliver deliver)
    : node_{node},
      endpoint_{std::move(endpoint)},
      route_{std::make_shared<Route>(Route{std::move(deliver), {}, {}})} {
  open(endpoint_.qos);
}

void ReaderSet::open(const QoS& qos) {
  const std::size_t index = readers_.size();
  auto deliver = [route = route_, index, &discovery = node_.discovery()](const Bytes& bytes,
                                                                         const auto& info) {
    const rtps::GUID_t& sender = info.sample_identity.writer_guid();
    if (route->requested.size() > 1) {
      const auto offered = discovery.policies(sender);  // unknown for a publisher that has left
      if (offered && strongest_fit(route->requested, *offered) != index) return true;
    }
    route->sender = sender;
    route->sequence = info.sample_identity.sequence_number().to64long();
    return route->deliver(bytes, info);
  };
  Endpoint endpoint = endpoint_;
  endpoint.qos = qos;
  route_->requested.push_back(policies_of(qos));
  readers_.push_back(node_.open_reader(endpoint, std::move(deliver)));
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
