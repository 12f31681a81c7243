// SPDX-License-Identifier: Apache-2.0
// Tests who gets a connection, and how often unauthenticated clients are answered.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "tandem/dashboard/web/access_token.hpp"
#include "tandem/dashboard/web/client_address.hpp"
#include "tandem/dashboard/web/connection_pool.hpp"
#include "tandem/dashboard/web/request_limit.hpp"
#include "tandem/dashboard/web/token_delay.hpp"

namespace tandem {
namespace {

boost::asio::ip::address ip(const std::string& text) { return boost::asio::ip::make_address(text); }

TEST(ConnectionPool, ClosesTheOldestOfAnAddressThatHasTooMany) {
  ConnectionPool pool{{.all = 8, .per_address = 2}};
  const auto other = pool.admit("b");
  const auto first = pool.admit("a"), second = pool.admit("a");
  EXPECT_FALSE(pool.evict());
  const auto third = pool.admit("a");
  EXPECT_EQ(pool.evict(), first);
  EXPECT_FALSE(pool.evict());
  pool.remove(second);
  pool.remove(third);
  pool.remove(other);
  EXPECT_EQ(pool.size(), 0U);
}

TEST(ConnectionPool, MakesRoomForANewcomerAtTheCostOfTheAddressWithTheMost) {
  ConnectionPool pool{{.all = 4, .per_address = 3}};
  const auto quiet = pool.admit("quiet");
  const auto oldest = pool.admit("busy");
  for (int i = 0; i < 2; ++i) (void)pool.admit("busy");
  EXPECT_FALSE(pool.evict());
  const auto late = pool.admit("late");
  EXPECT_EQ(pool.evict(), oldest);
  EXPECT_FALSE(pool.evict());
  pool.remove(quiet);
  pool.remove(late);
  EXPECT_EQ(pool.size(), 2U);
}

TEST(ConnectionPool, ClosesTheOldestOfAllWhenEachAddressHasOne) {
  ConnectionPool pool{{.all = 3, .per_address = 3}};
  const auto oldest = pool.admit("z");
  for (const char* address : {"y", "x", "a"}) (void)pool.admit(address);
  EXPECT_EQ(pool.evict(), oldest);
  EXPECT_FALSE(pool.evict());
}

TEST(ConnectionPool, SixtyHalfOpenConnectionsLeaveRoomForEverybody) {
  ConnectionPool pool{{}};
  std::set<ConnectionPool::Id> closed;
  for (int i = 0; i < 60; ++i) {
    (void)pool.admit("attacker");
    while (const auto id = pool.evict()) closed.insert(*id);
  }
  EXPECT_EQ(pool.size(), ConnectionPool::Limits{}.per_address);
  for (const char* address : {"somebody else", "attacker"}) {  // behind one router, perhaps
    const auto mine = pool.admit(address);
    while (const auto id = pool.evict()) closed.insert(*id);
    EXPECT_FALSE(closed.contains(mine)) << address;
  }
}

TEST(ConnectionPool, CountsAProxiedConnectionOnlyOnceItsClientIsKnown) {
  ConnectionPool pool{{.all = 8, .per_address = 2}};
  std::vector<ConnectionPool::Id> all;
  for (int i = 0; i < 6; ++i) all.push_back(pool.admit(""));
  EXPECT_FALSE(pool.evict());
  for (int i = 0; i < 3; ++i) pool.set_address(all[static_cast<std::size_t>(i)], "a");
  EXPECT_EQ(pool.evict(), all[0]);
  pool.set_address(all[0], "b");
  EXPECT_EQ(pool.size(), 5U) << "what was closed does not come back";
}

TEST(TokenDelay, GrowsForEachWrongTokenUpToItsLimit) {
  TokenDelay delay;
  for (int i = 0; i < TokenDelay::kFree; ++i) EXPECT_EQ(delay.wrong("a", 0.0), 0.0) << i;
  double now = 0.0, last = 0.0;
  for (int i = 0; i < 10; ++i) {
    const double wait = delay.wrong("a", now);
    EXPECT_GT(wait, 0.0);
    EXPECT_GE(wait, last);
    EXPECT_LE(wait, TokenDelay::kLongest);
    last = wait;
  }
  EXPECT_EQ(last, TokenDelay::kLongest);
  EXPECT_EQ(delay.wrong("b", now), 0.0) << "nobody waits for another";
  now += TokenDelay::kLongest;
  EXPECT_EQ(delay.wrong("a", now), 0.0);
  EXPECT_GT(delay.wrong("a", now), 0.0);
}

TEST(TokenDelay, ForgetsAfterAWhileAndRemembersAtMostSoManyAddresses) {
  TokenDelay delay;
  for (int i = 0; i < 20; ++i) (void)delay.wrong("a", 0.0);
  EXPECT_EQ(delay.wrong("a", TokenDelay::kMemory + 1.0), 0.0);
  for (int i = 0; i < 5000; ++i) (void)delay.wrong(std::to_string(i), TokenDelay::kMemory + 2.0);
  EXPECT_LE(delay.size(), TokenDelay::kAddresses);
}

TEST(RequestLimit, HoldsForEachAddressAndRemembersAtMostSoMany) {
  RequestLimit limit;
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(limit.allows("a", 0.0));
  EXPECT_FALSE(limit.allows("a", 0.0));
  EXPECT_TRUE(limit.allows("b", 0.0));
  EXPECT_TRUE(limit.allows("a", 0.06));
  for (int i = 0; i < 5000; ++i) EXPECT_TRUE(limit.allows(std::to_string(i), 0.1));
  EXPECT_LE(limit.size(), RequestLimit::kAddresses);
}

TEST(ClientAddress, IsThePeersUnlessThePeerIsATrustedProxy) {
  const auto proxies = trusted_proxies("127.0.0.1 10.0.0.2");
  EXPECT_EQ(client_address(ip("10.0.0.9"), "1.2.3.4", proxies), "10.0.0.9");
  EXPECT_EQ(client_address(ip("127.0.0.1"), "1.2.3.4", proxies), "1.2.3.4");
  EXPECT_EQ(client_address(ip("127.0.0.1"), "", proxies), "127.0.0.1");
  EXPECT_EQ(client_address(ip("127.0.0.1"), "1.2.3.4", {}), "127.0.0.1");
  EXPECT_EQ(client_address(ip("::ffff:127.0.0.1"), "1.2.3.4", proxies), "1.2.3.4");
}

TEST(ClientAddress, IsTheLastThatNoTrustedProxyHas) {
  const auto proxies = trusted_proxies("127.0.0.1 10.0.0.2");
  const auto of = [&](const char* header) {
    return client_address(ip("127.0.0.1"), header, proxies);
  };
  EXPECT_EQ(of("6.6.6.6, 1.2.3.4"), "1.2.3.4") << "earlier entries are only claimed by the client";
  EXPECT_EQ(of("6.6.6.6, 1.2.3.4, 10.0.0.2"), "1.2.3.4");
  EXPECT_EQ(of("10.0.0.2,127.0.0.1"), "10.0.0.2");
  EXPECT_EQ(of(" 1.2.3.4:567 "), "1.2.3.4");
  EXPECT_EQ(of("1.2.3.4, nonsense"), "127.0.0.1");
  EXPECT_EQ(of(", ,"), "127.0.0.1");
}

TEST(ClientAddress, OfIpV6CountsByItsSubscriber) {
  const auto proxies = trusted_proxies("::1");
  EXPECT_EQ(client_address(ip("2001:db8:1:2:3:4:5:6"), "", {}), "2001:db8:1:2::/64");
  EXPECT_EQ(client_address(ip("2001:db8:1:2:ffff::1"), "", {}), "2001:db8:1:2::/64");
  EXPECT_EQ(client_address(ip("::1"), "[2001:db8:1:2::9]:80", proxies), "2001:db8:1:2::/64");
  EXPECT_EQ(client_address(ip("::1"), "[", proxies), "::/64");
}

TEST(TrustedProxies, AreAddressesOnly) {
  EXPECT_TRUE(trusted_proxies("").empty());
  EXPECT_EQ(trusted_proxies("  127.0.0.1   ::1 ").size(), 2U);
  EXPECT_THROW((void)trusted_proxies("localhost"), std::invalid_argument);
  EXPECT_THROW((void)trusted_proxies("10.0.0.0/8"), std::invalid_argument);
}

// 32 digits of 16 kinds, each as often as the others: a digit that is not would show in 10⁵ of them
// by more than 6 standard deviations (75).
TEST(AccessToken, HasA128BitsOfChance) {
  std::set<std::string> seen;
  std::map<char, int> digits;
  for (int i = 0; i < 3125; ++i) {
    const auto token = new_token();
    ASSERT_EQ(token.size(), 32U);
    ASSERT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_TRUE(seen.insert(token).second);
    for (const char digit : token) ++digits[digit];
  }
  EXPECT_EQ(digits.size(), 16U);
  for (const auto& [digit, times] : digits) EXPECT_NEAR(times, 100'000 / 16, 6 * 77) << digit;
}

}  // namespace
}  // namespace tandem
