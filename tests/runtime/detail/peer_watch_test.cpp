// SPDX-License-Identifier: Apache-2.0
// Tests what a node reports about peers that it cannot receive from or reach.
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/detail/discovery.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using geometry_msgs::msg::Twist;
using geometry_msgs::msg::TwistStamped;
using test::spin_until;

using test::kTimeout;
constexpr double kSettled = 1.5;  // [s] after which a node has said what it has to say
constexpr rt::Topic<Twist> kTwist{"cmd_vel"};
constexpr rt::Topic<TwistStamped> kStamped{"cmd_vel"};
constexpr rt::Topic<std_msgs::msg::Bool> kStop{"e_stop", rt::kLatched};

void let_pass(double seconds, rt::Node& node) {
  ASSERT_FALSE(spin_until([] { return false; }, seconds, node));
}

TEST(QosMismatches, AreThePoliciesOfWhichTooLittleIsOffered) {
  const rt::Policies best_effort{}, reliable{.reliability = 1},
      latched{.reliability = 1, .durability = 1};
  EXPECT_TRUE(rt::qos_mismatches(latched, best_effort).empty());
  EXPECT_TRUE(rt::qos_mismatches(reliable, reliable).empty());
  const auto found = rt::qos_mismatches(best_effort, latched);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].policy, "reliability");
  EXPECT_EQ(found[0].offered, "best effort");
  EXPECT_EQ(found[0].requested, "reliable");
  EXPECT_EQ(found[1].policy, "durability");
  EXPECT_EQ(found[1].offered, "volatile");
  EXPECT_EQ(found[1].requested, "transient local");
}

TEST(QosMismatches, KnowDeadlineAndLiveliness) {
  const rt::Policies ours{};
  EXPECT_EQ(rt::qos_mismatches(ours, {.deadline = 0.1}).at(0).policy, "deadline");
  EXPECT_EQ(rt::qos_mismatches(ours, {.liveliness = 2}).at(0).policy, "liveliness");
  EXPECT_TRUE(rt::qos_mismatches({.deadline = 0.1, .liveliness = 2}, ours).empty());
}

TEST(PeerWatch, ReportsIncompatibleQosOnce) {
  test::CapturedLog log;
  rt::Node node{"picky"}, other{"careless"};
  const auto publisher = other.create_publisher(kTwist, rt::kBestEffort(5));
  const auto subscription = node.create_subscription(kTwist, [](const auto&) {});
  const std::string said =
      "/cmd_vel: a publisher has incompatible QoS, nothing from it arrives at this node "
      "(reliability: it "
      "offers best effort, this node requests reliable)";
  EXPECT_TRUE(spin_until([&] { return log.lines(said) == 1; }, kTimeout, node));
  const auto late = other.create_publisher(rt::Topic<Twist>{"elsewhere"});  // makes it look again
  let_pass(kSettled, node);
  EXPECT_EQ(log.lines("incompatible QoS"), 1);
}

TEST(PeerWatch, NamesTheParametersThatResolveAMismatch) {
  test::CapturedLog log;
  rt::Node node{"strict"}, other{"careless"};
  const auto subscription = node.create_subscription(kStop, [](const auto&) {});
  const auto publisher = node.create_publisher(kTwist, rt::kBestEffort(1));
  const auto weak = other.create_publisher(kStop, rt::kBestEffort(1));
  const auto deaf = other.create_subscription(kTwist, rt::kLatched, [](const auto&) {});
  const std::string mends_subscription =
      "; set qos_overrides./e_stop.subscription.reliability: best_effort and "
      "qos_overrides./e_stop.subscription.durability: volatile";
  const std::string mends_publisher =
      "; set qos_overrides./cmd_vel.publisher.reliability: reliable and "
      "qos_overrides./cmd_vel.publisher.durability: transient_local";
  EXPECT_TRUE(spin_until(
      [&] { return log.lines(mends_subscription) == 1 && log.lines(mends_publisher) == 1; },
      kTimeout, node));
}

TEST(PeerWatch, NamesNoParameterIfNoneResolvesIt) {
  EXPECT_EQ(rt::override_for({"deadline", "none", "0.1 s"}, false), "");
  EXPECT_EQ(rt::override_for({"liveliness", "automatic", "manual by topic"}, false), "");
  EXPECT_EQ(rt::override_for({"durability", "transient local", "persistent"}, false), "");
  test::CapturedLog log;
  rt::Node node{"untyped"}, other{"careless"};
  const auto generic = node.create_generic_subscription("/cmd_vel", "geometry_msgs/msg/Twist",
                                                        rt::kDefault, [](const auto&) {});
  const auto publisher = other.create_publisher(kTwist, rt::kBestEffort(5));
  EXPECT_TRUE(spin_until([&] { return log.lines("incompatible QoS") == 1; }, kTimeout, node));
  EXPECT_EQ(log.lines("qos_overrides"), 0) << "it reads no such parameters";
}

TEST(PeerWatch, NoticesPeersThatJoinLater) {
  test::CapturedLog log;
  rt::Node node{"patient"}, other{"late"};
  const auto subscription = node.create_subscription(kTwist, [](const auto&) {});
  bool stamped = false;
  const auto request =
      node.watch_publishers(kStamped, [&](const auto& offered) { stamped = !offered.empty(); });
  let_pass(kSettled, node);
  const auto careless = other.create_publisher(kTwist, rt::kBestEffort(5));
  const auto publisher = other.create_publisher(kStamped);
  EXPECT_TRUE(
      spin_until([&] { return stamped && log.lines("incompatible QoS") == 1; }, kTimeout, node));
}

TEST(PeerWatch, ReportsSubscriptionsToo) {
  test::CapturedLog log;
  rt::Node node{"volatile"}, other{"late"};
  const auto publisher = node.create_publisher(kStop, rt::kDefault);
  const auto subscription = other.create_subscription(kStop, [](const auto&) {});
  EXPECT_TRUE(spin_until(
      [&] {
        return log.lines(
                   "/e_stop: a subscription has incompatible QoS, it receives nothing from this "
                   "node "
                   "(durability: it requests transient local, this node offers volatile)") == 1;
      },
      kTimeout, node));
}

TEST(PeerWatch, IsSilentWhereOneOfTwoSubscriptionsFits) {
  test::CapturedLog log;
  rt::Node node{"arbitration"}, other{"button"};
  const auto publisher = other.create_publisher(kStop, rt::kDefault);
  int heard = 0;
  const auto latched = node.create_subscription(kStop, [&](const auto&) { ++heard; });
  const auto any =
      node.create_subscription(kStop, rt::kBestEffort(10), [&](const auto&) { ++heard; });
  ASSERT_TRUE(spin_until([&] { return publisher.matched() == 1; }, kTimeout, node));
  let_pass(kSettled, node);
  EXPECT_EQ(log.lines("incompatible QoS"), 0);
}

TEST(PeerWatch, ReportsAMismatchedType) {
  test::CapturedLog log;
  rt::Node node{"plain"}, other{"stamping"};
  const auto publisher = other.create_publisher(kStamped);
  const auto subscription = node.create_subscription(kTwist, [](const auto&) {});
  EXPECT_TRUE(spin_until(
      [&] {
        return log.lines(
                   "/cmd_vel: a publisher of geometry_msgs/msg/TwistStamped does not fit "
                   "this node's geometry_msgs/msg/Twist: nothing from it arrives at this node") ==
               1;
      },
      kTimeout, node));
}

TEST(PeerWatch, CallsBackWhenPublishersOfTheTypeComeAndLeave) {
  rt::Node node{"waiting"}, other{"stamping"};
  std::vector<std::size_t> calls;  // how many publishers there were
  int best_effort = 0;
  const auto request = node.watch_publishers(kStamped, [&](const auto& offered) {
    calls.push_back(offered.size());
    for (const auto& publisher : offered) best_effort += 1 - publisher.reliability;
  });
  const auto plain = other.create_publisher(kTwist);
  EXPECT_FALSE(spin_until([&] { return !calls.empty(); }, 0.3, node));
  for (const std::size_t round : {1U, 2U}) {
    auto stamped = std::optional{other.create_publisher(kStamped)};
    ASSERT_TRUE(spin_until([&] { return calls.size() == 4 * round - 3; }, kTimeout, node));
    auto second = std::optional{other.create_publisher(kStamped, rt::kBestEffort(1))};
    ASSERT_TRUE(spin_until([&] { return calls.size() == 4 * round - 2; }, kTimeout, node));
    EXPECT_EQ(best_effort, static_cast<int>(round));
    stamped.reset();
    ASSERT_TRUE(spin_until([&] { return calls.size() == 4 * round - 1; }, kTimeout, node));
    second.reset();
    ASSERT_TRUE(spin_until([&] { return calls.size() == 4 * round; }, kTimeout, node));
    best_effort = static_cast<int>(round);
  }
  EXPECT_EQ(calls, (std::vector<std::size_t>{1, 2, 1, 0, 1, 2, 1, 0}));
}

TEST(PeerWatch, DoesNotCallBackAfterCancellation) {
  rt::Node node{"gone"};
  int calls = 0;
  auto request = node.watch_publishers(kStamped, [&](const auto&) { ++calls; });
  request.reset();
  const auto stamped = node.create_publisher(kStamped);
  let_pass(0.3, node);
  EXPECT_EQ(calls, 0);
}

TEST(Topics, CarryTwoTypesUnderOneName) {
  rt::Node node{"both"};
  double plain_v = 0.0, stamped_v = 0.0;
  const auto plain = node.create_publisher(kTwist);
  const auto stamped = node.create_publisher(kStamped);
  const auto plain_in =
      node.create_subscription(kTwist, [&](const Twist& msg) { plain_v = msg.linear().x(); });
  const auto stamped_in = node.create_subscription(
      kStamped, [&](const TwistStamped& msg) { stamped_v = msg.twist().linear().x(); });
  ASSERT_TRUE(
      spin_until([&] { return plain.matched() == 1 && stamped.matched() == 1; }, kTimeout, node));
  Twist msg;
  msg.linear().x(1.0);
  plain.publish(msg);
  TwistStamped with_stamp;
  with_stamp.twist().linear().x(2.0);
  stamped.publish(with_stamp);
  ASSERT_TRUE(spin_until([&] { return plain_v > 0.0 && stamped_v > 0.0; }, kTimeout, node));
  EXPECT_EQ(plain_v, 1.0);
  EXPECT_EQ(stamped_v, 2.0);
}

TEST(Topics, RefuseAThirdTypeUnderOneName) {
  rt::Node node{"three"};
  const auto plain = node.create_publisher(kTwist);
  const auto stamped = node.create_publisher(kStamped);
  try {
    const auto third = node.create_publisher(rt::Topic<std_msgs::msg::Bool>{"cmd_vel"});
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(
        error.what(),
        "topic /cmd_vel is in use in this process with two other types, so it cannot have type "
        "std_msgs/msg/Bool too");
  }
}

// A late subscriber does not receive a sample whose lifespan has expired, so no old command is
// executed after a reconnect.
TEST(Lifespan, KeepsOldSamplesFromLateSubscriptions) {
  rt::Node node{"lifespan"};
  rt::QoS brief = rt::kLatched;
  brief.lifespan = 0.1;
  const auto lasting = node.create_publisher(rt::Topic<Twist>{"lasting", rt::kLatched});
  const auto fleeting = node.create_publisher(rt::Topic<Twist>{"fleeting", brief});
  lasting.publish({});
  fleeting.publish({});
  let_pass(0.3, node);
  int got_lasting = 0, got_fleeting = 0;
  const auto a = node.create_subscription(rt::Topic<Twist>{"fleeting", rt::kLatched},
                                          [&](const auto&) { ++got_fleeting; });
  const auto b = node.create_subscription(rt::Topic<Twist>{"lasting", rt::kLatched},
                                          [&](const auto&) { ++got_lasting; });
  ASSERT_TRUE(spin_until([&] { return got_lasting == 1; }, kTimeout, node));
  let_pass(0.2, node);
  EXPECT_EQ(got_fleeting, 0);
  fleeting.publish({});
  EXPECT_TRUE(spin_until([&] { return got_fleeting == 1; }, kTimeout, node));
}

// Lyrical's rmw_fastrtps adds the key bufbe, whose value has colons.
TEST(UserData, GivesTheTypeHashAmongKeysThatAreNotKnown) {
  const std::string hash = "RIHS01_9c45bf16";
  for (const std::string text :
       {"typehash=RIHS01_9c45bf16;", "typehash=RIHS01_9c45bf16",
        "bufbe=cpu:1,cuda:2;typehash=RIHS01_9c45bf16;", "typehash=RIHS01_9c45bf16;bufbe=cpu:1;",
        ";;bufbe;typehash=RIHS01_9c45bf16;",
        "enclave=/;oldtypehash=RIHS01_0;typehash=RIHS01_9c45bf16"})
    EXPECT_EQ(rt::type_hash_in(text), hash) << text;
  for (const std::string text : {"", ";", "bufbe=cpu:1;", "oldtypehash=RIHS01_0;", "typehash"})
    EXPECT_EQ(rt::type_hash_in(text), "") << text;
}

}  // namespace
}  // namespace tandem
