// SPDX-License-Identifier: Apache-2.0
// Tests what discovery knows of endpoints and which nodes it wakes for them.
#include "tandem/runtime/detail/discovery.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tandem/runtime/detail/discovery_watcher.hpp"
#include "tandem/runtime/detail/peer_watch.hpp"
#include "tandem/runtime/detail/wake_up.hpp"

namespace tandem::runtime {
namespace {

using Topics = std::set<std::string>;

rtps::GUID_t guid(int number) {
  rtps::GUID_t guid;
  guid.guidPrefix.value[0] = 1;
  guid.entityId.value[0] = static_cast<rtps::octet>(number);
  return guid;
}

KnownEndpoint publisher(int number, const std::string& topic) {
  return {.guid = guid(number), .writes = true, .topic = topic, .type = "T", .policies = {}};
}

std::vector<std::string> topics_of(const KnownEndpoints& endpoints) {
  std::vector<std::string> topics;
  for (const auto& endpoint : endpoints) topics.push_back(endpoint->topic);
  return topics;
}

TEST(Discovery, ListsTheEndpointsOfATopic) {
  Discovery discovery;
  for (const auto& endpoint : {publisher(1, "a"), publisher(2, "b"), publisher(3, "a")})
    discovery.add(endpoint);
  EXPECT_EQ(discovery.endpoints().size(), 3U);
  EXPECT_EQ(discovery.endpoints_on("a").size(), 2U);
  discovery.remove(guid(1));
  EXPECT_EQ(discovery.endpoints().size(), 2U);
  ASSERT_EQ(discovery.endpoints_on("a").size(), 1U);
  EXPECT_EQ(discovery.endpoints_on("a").front()->guid, guid(3));
  discovery.remove(guid(3));
  EXPECT_TRUE(discovery.endpoints_on("a").empty());
}

// Only a faulty or hostile program announces such a thing.
TEST(Discovery, MovesAnEndpointThatIsAnnouncedOnAnotherTopic) {
  Discovery discovery;
  const auto watcher = std::make_shared<DiscoveryWatcher>(std::make_shared<WakeUp>());
  watcher->watch({"a"});
  discovery.add(watcher);
  discovery.add(publisher(1, "a"));
  EXPECT_EQ(watcher->take(), Topics{"a"});
  discovery.add(publisher(1, "b"));
  EXPECT_EQ(watcher->take(), Topics{"a"}) << "it has left";
  EXPECT_TRUE(discovery.endpoints_on("a").empty());
  EXPECT_EQ(topics_of(discovery.endpoints_on("b")), std::vector<std::string>{"b"});
  EXPECT_EQ(topics_of(discovery.endpoints()), std::vector<std::string>{"b"});
}

TEST(Discovery, NotesChangesOnWatchedTopicsOnly) {
  Discovery discovery;
  const auto wake_up = std::make_shared<WakeUp>();
  const auto watcher = std::make_shared<DiscoveryWatcher>(wake_up);
  watcher->watch({"a", "b"});
  discovery.add(watcher);
  discovery.add(publisher(1, "elsewhere"));
  discovery.remove(guid(1));
  EXPECT_FALSE(watcher->has_changes());
  EXPECT_FALSE(wake_up->take());

  discovery.add(publisher(1, "a"));
  EXPECT_TRUE(wake_up->take());
  discovery.add(publisher(2, "b"));
  EXPECT_FALSE(wake_up->take()) << "it has not taken the first change yet";
  EXPECT_EQ(watcher->take(), (Topics{"a", "b"}));
  EXPECT_FALSE(watcher->has_changes());

  discovery.remove(guid(2));
  EXPECT_TRUE(wake_up->take());
  EXPECT_EQ(watcher->take(), Topics{"b"});
}

TEST(Discovery, TakesNoRepeatedAnnouncementForAChange) {
  Discovery discovery;
  const auto watcher = std::make_shared<DiscoveryWatcher>(std::make_shared<WakeUp>());
  watcher->watch({"a"});
  discovery.add(watcher);
  KnownEndpoint endpoint = publisher(1, "a");
  endpoint.since = 5.0;
  discovery.add(endpoint);
  EXPECT_EQ(watcher->take(), Topics{"a"});
  endpoint.since = 7.0;
  discovery.add(endpoint);
  EXPECT_FALSE(watcher->has_changes());
  endpoint.policies.reliability = 1;
  discovery.add(endpoint);
  EXPECT_EQ(watcher->take(), Topics{"a"});
  EXPECT_EQ(discovery.endpoints().front()->since, 5.0) << "it was first seen then";
}

// So the thousands of endpoints of a fleet cost a robot's nodes nothing.
TEST(PeerWatch, LooksAgainForChangesOnItsTopicsOnlyAndOnceNewPeersHaveSettled) {
  constexpr double kSettling = 1.0;  // [s]
  Discovery discovery;
  Logger log{"test"};
  PeerWatch peers{discovery, log, kSettling, std::make_shared<WakeUp>()};
  Endpoint own;
  own.topic = "a";
  own.type = "T";
  peers.add(guid(100), own, false);
  double now = 10.0;
  EXPECT_LE(peers.due(), now);
  peers.poll(now);
  EXPECT_TRUE(std::isinf(peers.due()));

  discovery.add(publisher(1, "elsewhere"));
  EXPECT_TRUE(std::isinf(peers.due()));
  KnownEndpoint peer = publisher(2, "a");
  peer.since = now;
  discovery.add(peer);
  EXPECT_LT(peers.due(), now + 0.5 * kSettling) << "publishers are watched";
  peers.poll(now += 0.5 * kSettling);
  EXPECT_DOUBLE_EQ(peers.due(), 10.0 + kSettling);
  peers.poll(now = peers.due());
  EXPECT_TRUE(std::isinf(peers.due()));
}

}  // namespace
}  // namespace tandem::runtime
