// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/peer_watch.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "tandem/runtime/names.hpp"

namespace tandem::runtime {
namespace {

constexpr double kLookPeriod = 0.1;  // [s] between two checks at least

std::string counted(const std::vector<QosMismatch>& mismatches, bool peer_writes) {
  std::string text;
  for (const auto& mismatch : mismatches)
    text += fmt::format("{}{}: {} {}, this node {} {}", text.empty() ? "" : "; ", mismatch.policy,
                        peer_writes ? "it offers" : "it requests",
                        peer_writes ? mismatch.offered : mismatch.requested,
                        peer_writes ? "requests" : "offers",
                        peer_writes ? mismatch.requested : mismatch.offered);
  return text;
}

// The parameters to set at this node; empty if they cannot resolve every mismatch.
std::string remedy(const std::vector<QosMismatch>& mismatches, const std::string& parameter,
                   bool peer_writes) {
  std::string text;
  for (const auto& mismatch : mismatches) {
    const std::string value = override_for(mismatch, peer_writes);
    if (parameter.empty() || value.empty()) return {};
    text += fmt::format("{} {}.{}", text.empty() ? "; set" : " and", parameter, value);
  }
  return text;
}

bool fits_request(const KnownEndpoint& peer, const std::string& topic, const std::string& type) {
  return peer.writes && peer.topic == topic && peer.type == type;
}

}  // namespace

PeerWatch::PeerWatch(Discovery& discovery, Logger& log, double settling,
                     std::shared_ptr<WakeUp> wake_up)
    : discovery_{discovery},
      log_{log},
      settling_{settling},
      others_{std::make_shared<DiscoveryWatcher>(std::move(wake_up))},
      polled_{-std::numeric_limits<double>::infinity()} {
  discovery.add(others_);
}

void PeerWatch::add(const rtps::GUID_t& guid, const Endpoint& endpoint, bool writes) {
  own_.push_back({guid, writes, endpoint});
  own_changed_ = true;
}

void PeerWatch::remove(const rtps::GUID_t& guid) {
  std::erase_if(own_, [&](const Own& own) { return own.guid == guid; });
  own_changed_ = true;
}

std::shared_ptr<void> PeerWatch::watch_publishers(const std::string& topic, const std::string& type,
                                                  PublishersChanged fn) {
  auto request = std::make_shared<Request>(Request{topic, type, std::move(fn), {}});
  requests_.push_back(request);
  own_changed_ = true;
  return request;
}

double PeerWatch::due() const {
  if (settled_ && !own_changed_ && !others_->changed)
    return std::numeric_limits<double>::infinity();
  return polled_ + kLookPeriod;
}

void PeerWatch::poll(double now) {
  polled_ = now;
  own_changed_ = false;
  others_->changed = false;  // before looking: a later change is another one
  const auto known = discovery_.endpoints();
  notify_requests(known);
  check(known, now);
}

void PeerWatch::notify_requests(const std::vector<KnownEndpoint>& known) {
  for (std::size_t i = 0; i < requests_.size(); ++i)  // a callback may add another
    if (const auto request = requests_[i].lock()) notify(*request, known);
  std::erase_if(requests_, [](const auto& request) { return request.expired(); });
}

void PeerWatch::notify(Request& request, const std::vector<KnownEndpoint>& known) {
  std::set<rtps::GUID_t> publishers;
  std::vector<Policies> offered;
  for (const auto& peer : known) {
    if (!fits_request(peer, request.topic, request.type)) continue;
    publishers.insert(peer.guid);
    offered.push_back(peer.policies);
  }
  if (publishers == request.reported) return;
  request.reported = std::move(publishers);
  request.fn(offered);
}

void PeerWatch::check(const std::vector<KnownEndpoint>& known, double now) {
  settled_ = true;
  std::erase_if(checked_, [&](const rtps::GUID_t& guid) {
    return std::none_of(known.begin(), known.end(), [&](const auto& e) { return e.guid == guid; });
  });
  for (const auto& peer : known) {
    if (checked_.contains(peer.guid)) continue;
    if (now - peer.since < settling_)
      settled_ = false;
    else
      check(peer, known);
  }
}

// One compatible endpoint of the node is enough: /e_stop, for example, has two readers.
void PeerWatch::check(const KnownEndpoint& peer, const std::vector<KnownEndpoint>& known) {
  std::vector<QosMismatch> worst;
  std::string mended;
  const Own* other_type = nullptr;
  for (const auto& own : own_) {
    if (own.endpoint.topic != peer.topic || own.writes == peer.writes) continue;
    checked_.insert(peer.guid);
    if (own.endpoint.type != peer.type) {
      other_type = &own;
      continue;
    }
    const Policies policies = policies_of(own.endpoint.qos);
    worst = peer.writes ? qos_mismatches(peer.policies, policies)
                        : qos_mismatches(policies, peer.policies);
    if (worst.empty()) return;
    mended = remedy(worst, own.endpoint.parameter, peer.writes);
  }
  const std::string topic = ros_name(peer.topic);
  const char* who = peer.writes ? "publisher" : "subscription";
  const char* effect =
      peer.writes ? "nothing from it arrives at this node" : "it receives nothing from this node";
  if (!worst.empty())
    log_.warn("{}: a {} has incompatible QoS, {} ({}){}", topic, who, effect,
              counted(worst, peer.writes), mended);
  else if (other_type != nullptr && !receives_other_type(peer, known))
    log_.warn("{}: a {} of {} does not fit this node's {}: {}", topic, who, ros_type(peer.type),
              ros_type(other_type->endpoint.type), effect);
}

// A process may have one endpoint per type on the same topic.
bool PeerWatch::receives_other_type(const KnownEndpoint& peer,
                                    const std::vector<KnownEndpoint>& known) const {
  return std::any_of(known.begin(), known.end(), [&](const KnownEndpoint& beside) {
    return same_process(beside.guid, peer.guid) && beside.writes == peer.writes &&
           beside.topic == peer.topic && beside.type != peer.type &&
           std::any_of(own_.begin(), own_.end(), [&](const Own& own) {
             return own.endpoint.topic == beside.topic && own.endpoint.type == beside.type &&
                    own.writes != beside.writes;
           });
  });
}

}  // namespace tandem::runtime
