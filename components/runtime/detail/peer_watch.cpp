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
  const double next = polled_ + kLookPeriod;
  if (own_changed_ || others_->has_changes()) return next;
  double settles = std::numeric_limits<double>::infinity();
  for (const auto& [topic, time] : settles_) settles = std::min(settles, time);
  return std::max(next, settles);
}

void PeerWatch::poll(double now) {
  polled_ = now;
  for (const auto& topic : topics_to_look_at(now)) look_at(topic, now);
  std::erase_if(requests_, [](const auto& request) { return request.expired(); });
}

std::set<std::string> PeerWatch::topics_to_look_at(double now) {
  if (std::exchange(own_changed_, false)) {
    auto topics = own_topics();
    const auto is_left = [&](const auto& entry) { return !topics.contains(entry.first); };
    std::erase_if(settles_, is_left);
    // What has been said of a peer is not said again if this node comes back to its topic.
    std::erase_if(checked_, [&](const auto& entry) {
      return is_left(entry) && discovery_.endpoints_on(entry.first).empty();
    });
    others_->watch(topics);  // before looking, so that no change is missed
    (void)others_->take();   // all of them are looked at
    return topics;
  }
  auto topics = others_->take();
  for (const auto& [topic, time] : settles_)
    if (time <= now) topics.insert(topic);
  return topics;
}

std::set<std::string> PeerWatch::own_topics() const {
  std::set<std::string> topics;
  for (const auto& own : own_) topics.insert(own.endpoint.topic);
  for (const auto& entry : requests_)
    if (const auto request = entry.lock()) topics.insert(request->topic);
  return topics;
}

void PeerWatch::look_at(const std::string& topic, double now) {
  const auto known = discovery_.endpoints_on(topic);
  notify_requests(topic, known);
  check(topic, known, now);
}

void PeerWatch::notify_requests(const std::string& topic, const KnownEndpoints& known) {
  for (std::size_t i = 0; i < requests_.size(); ++i) {  // a callback may add another
    const auto request = requests_[i].lock();
    if (request && request->topic == topic) notify(*request, known);
  }
}

void PeerWatch::notify(Request& request, const KnownEndpoints& known) {
  std::set<rtps::GUID_t> publishers;
  std::vector<Policies> offered;
  for (const auto& peer : known) {
    if (!peer->writes || peer->type != request.type) continue;
    publishers.insert(peer->guid);
    offered.push_back(peer->policies);
  }
  if (publishers == request.reported) return;
  request.reported = std::move(publishers);
  request.fn(offered);
}

void PeerWatch::check(const std::string& topic, const KnownEndpoints& known, double now) {
  const auto checked = std::exchange(checked_[topic], {});  // those that have left are forgotten
  double next = std::numeric_limits<double>::infinity();
  for (const auto& peer : known) {
    const double settles = peer->since + settling_;
    if (checked.contains(peer->guid))
      checked_[topic].insert(peer->guid);
    else if (now < settles)
      next = std::min(next, settles);
    else
      check(*peer, known);
  }
  settles_[topic] = next;
}

// One compatible endpoint of the node is enough: /e_stop, for example, has two readers.
void PeerWatch::check(const KnownEndpoint& peer, const KnownEndpoints& known) {
  std::vector<QosMismatch> worst;
  std::string mended;
  const Own* other_type = nullptr;
  for (const auto& own : own_) {
    if (own.endpoint.topic != peer.topic || own.writes == peer.writes) continue;
    checked_[peer.topic].insert(peer.guid);
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
bool PeerWatch::receives_other_type(const KnownEndpoint& peer, const KnownEndpoints& known) const {
  return std::any_of(known.begin(), known.end(), [&](const auto& beside) {
    return same_process(beside->guid, peer.guid) && beside->writes == peer.writes &&
           beside->type != peer.type && std::any_of(own_.begin(), own_.end(), [&](const Own& own) {
             return own.endpoint.topic == beside->topic && own.endpoint.type == beside->type &&
                    own.writes != beside->writes;
           });
  });
}

}  // namespace tandem::runtime
