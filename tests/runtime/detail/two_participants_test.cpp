// SPDX-License-Identifier: Apache-2.0
// A process that uses a topic with two types has two participants. Checks that they know each
// other's endpoints, however many come and go while they meet.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/domain_view.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem::test {
namespace {

using geometry_msgs::msg::Twist;
using geometry_msgs::msg::TwistStamped;

constexpr std::array kNames{"/t0", "/t1", "/t2", "/t3", "/t4"};

template <class M>
std::vector<rt::Publisher<M>> publishers_on_all(rt::Node& node) {
  std::vector<rt::Publisher<M>> all;
  for (const char* name : kNames) all.push_back(node.create_publisher(rt::Topic<M>{name, {}}));
  return all;
}

// Makes nodes with endpoints in both participants and destroys them. With the services of every
// node they would announce more endpoints than the guard admits. What it drops is sent again and
// again, and Fast DDS 2.9.1 may come to a deadlock if a participant ends meanwhile (mended
// in 2.14.5: StatefulWriter and its flow controller lock each other's mutex).
void come_and_go(const std::string& name, unsigned seed) {
  constexpr int kNodes = 6;
  std::mt19937 random{seed};
  for (int n = 0; n < kNodes; ++n) {
    rt::Node node{rt::NodeOptions{.name = name, .serves_tools = false}};
    std::vector<rt::Publisher<Twist>> plain;
    std::vector<rt::Publisher<TwistStamped>> stamped;
    for (int i = 0; i < 3; ++i) {
      plain.push_back(node.create_publisher(rt::Topic<Twist>{kNames[random() % 5], {}}));
      stamped.push_back(node.create_publisher(rt::Topic<TwistStamped>{kNames[random() % 5], {}}));
    }
  }
}

// The node's publishers of Twist, which are in the second participant.
std::size_t known_of(const rt::DomainView& view, const std::string& node) {
  std::size_t count = 0;
  for (const auto& endpoint : view.look().endpoints)
    if (endpoint.node == node && endpoint.writes && endpoint.type == "geometry_msgs/msg/Twist")
      ++count;
  return count;
}

void meet(unsigned seed) {
  rt::Node first{"first"};
  const auto stamped = publishers_on_all<TwistStamped>(first);
  rt::Node watcher{"watcher"};
  const rt::DomainView view{watcher};
  std::thread one{come_and_go, "one", 2 * seed};
  std::thread two{come_and_go, "two", 2 * seed + 1};
  one.join();
  two.join();
  rt::Node late{"late"};
  const auto plain = publishers_on_all<Twist>(late);
  EXPECT_TRUE(
      spin_until([&] { return known_of(view, "/late") == kNames.size(); }, kTimeout, watcher))
      << known_of(view, "/late");
}

// One of about a hundred meetings failed before; TANDEM_TEST_LONG=1 makes a thousand.
TEST(TwoParticipants, KnowEachOthersEndpoints) {
  const unsigned meetings = std::getenv("TANDEM_TEST_LONG") != nullptr ? 1000 : 20;
  const CapturedLog log;
  for (unsigned seed = 0; seed < meetings && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    meet(seed);
  }
  EXPECT_EQ(log.lines("too many announcements"), 0);
}

}  // namespace
}  // namespace tandem::test
