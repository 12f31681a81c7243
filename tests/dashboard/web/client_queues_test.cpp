// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/client_queues.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>

namespace tandem {
namespace {

using Kind = WebEvent::Kind;

// Clients 1 to `count`, all accepted.
ClientQueues queues_of(ClientId count, ClientQueues::Limits limits = {}) {
  ClientQueues queues{limits};
  for (ClientId client = 1; client <= count; ++client) queues.join(client, 0.0);
  for (ClientId client = 1; client <= count; ++client)
    EXPECT_EQ(queues.next(Lane::kJoined, 0.0)->client, client);
  return queues;
}

WebEvent say(ClientId client, std::string text) { return {client, Kind::kText, std::move(text)}; }
WebEvent press(ClientId client, const std::string& what) {
  return {client, Kind::kBinary, "stop" + what};
}

TEST(RateLimit, AllowsABurstAndThenItsRate) {
  RateLimit limit{10.0, 20.0, 0.0};
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(limit.allows(0.0));
  EXPECT_FALSE(limit.allows(0.0));
  EXPECT_TRUE(limit.allows(0.1001));
  EXPECT_FALSE(limit.allows(0.1001));
  EXPECT_FALSE(limit.allows(0.05)) << "a clock that goes back gives nothing";
}

TEST(ClientBudget, IsPaidBackAtItsShareAndOwesNoMoreThanItsLimit) {
  ClientBudget budget{0.0};
  EXPECT_DOUBLE_EQ(budget.left(0.0), 0.5 * ClientBudget::kBurst);
  EXPECT_DOUBLE_EQ(budget.left(1e6), ClientBudget::kBurst);
  budget.charge(ClientBudget::kBurst + 1.0, 1e6);
  EXPECT_NEAR(budget.left(1e6 + 10.0), -1.0 + 10.0 * ClientBudget::kShare, 1e-9);
  budget.charge(1e9, 1e6 + 10.0);
  EXPECT_NEAR(budget.left(1e6 + 10.0), -ClientBudget::kMaxDebt, 1e-9);
}

TEST(ClientQueues, KeepTheOrderOfEachClient) {
  auto queues = queues_of(1);
  for (const char* text : {"a", "b", "c"}) ASSERT_TRUE(queues.push(say(1, text)));
  for (const char* text : {"a", "b", "c"}) EXPECT_EQ(queues.next(Lane::kUsual, 0.0)->bytes, text);
  EXPECT_FALSE(queues.next(Lane::kUsual, 0.0));
}

TEST(ClientQueues, ServeTheClientThatHasCostLeast) {
  auto queues = queues_of(15);
  for (ClientId client = 1; client <= 14; ++client)
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(queues.push(say(client, "heavy")));
  std::map<ClientId, int> served;
  for (int i = 0; i < 140; ++i) {
    const auto event = queues.next(Lane::kUsual, 0.0);
    ASSERT_TRUE(event);
    queues.charge(event->client, 0.001, 0.0);
    ++served[event->client];
  }
  for (const auto& [client, times] : served) EXPECT_EQ(times, 10) << client;
  ASSERT_TRUE(queues.push(say(15, "light")));
  EXPECT_EQ(queues.next(Lane::kUsual, 0.0)->client, 15U) << "it has cost nothing yet";
}

TEST(ClientQueues, LetAClientWithoutWorkLeftWait) {
  auto queues = queues_of(1);
  ASSERT_TRUE(queues.push(say(1, "a")));
  queues.charge(1, 0.5 * ClientBudget::kBurst + 0.1, 0.0);
  EXPECT_FALSE(queues.next(Lane::kUsual, 0.0));
  EXPECT_FALSE(queues.next(Lane::kUsual, 0.9 * 0.1 / ClientBudget::kShare));
  EXPECT_TRUE(queues.next(Lane::kUsual, 1.1 * 0.1 / ClientBudget::kShare));
}

TEST(ClientQueues, AreBoundedInFramesAndBytesForEachClient) {
  auto queues = queues_of(2, {.frames = 3, .bytes = 10, .urgent = 2});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queues.push(say(1, "a")));
  EXPECT_FALSE(queues.push(say(1, "a")));
  EXPECT_TRUE(queues.push(say(2, "0123456789"))) << "the other has a queue of its own";
  EXPECT_FALSE(queues.push(say(2, "0")));
  EXPECT_TRUE(queues.next(Lane::kUsual, 0.0));
  EXPECT_TRUE(queues.push(say(1, "a")));
  EXPECT_FALSE(queues.push(say(7, "a"))) << "of a client that never joined";
}

TEST(ClientQueues, PutPressesAheadOfTheirOwnClientsOtherFrames) {
  auto queues = queues_of(1);
  queues.set_urgent(1, {"stop"});
  ASSERT_TRUE(queues.push(say(1, "stopper"))) << "text is not a message";
  ASSERT_TRUE(queues.push(press(1, "!")));
  EXPECT_EQ(queues.next(Lane::kUrgent, 0.0)->bytes, "stop!");
  EXPECT_FALSE(queues.next(Lane::kUrgent, 0.0));
  EXPECT_EQ(queues.next(Lane::kUsual, 0.0)->bytes, "stopper");
}

TEST(ClientQueues, KeepPressesAndReleasesInOrderWhenTheChannelBecomesUrgentLate) {
  auto queues = queues_of(1);
  ASSERT_TRUE(queues.push(press(1, "pressed")));
  ASSERT_TRUE(queues.push(say(1, "other")));
  queues.set_urgent(1, {"stop"});
  ASSERT_TRUE(queues.push(press(1, "released")));
  EXPECT_EQ(queues.next(Lane::kUrgent, 0.0)->bytes, "stoppressed");
  EXPECT_EQ(queues.next(Lane::kUrgent, 0.0)->bytes, "stopreleased");
  EXPECT_EQ(queues.next(Lane::kUsual, 0.0)->bytes, "other");
}

TEST(ClientQueues, ServePressesInTurnWhateverOthersPress) {
  auto queues = queues_of(15);
  for (ClientId client = 1; client <= 15; ++client) queues.set_urgent(client, {"stop"});
  for (ClientId client = 1; client <= 14; ++client)
    for (int i = 0; i < 16; ++i) ASSERT_TRUE(queues.push(press(client, std::to_string(i % 2))));
  ASSERT_TRUE(queues.push(press(15, "!")));
  int before = 0;
  while (queues.next(Lane::kUrgent, 0.0)->client != 15) ++before;
  EXPECT_LE(before, 14);
}

TEST(ClientQueues, TakeARepeatedPressOnceAndLimitTheRest) {
  auto queues = queues_of(1);
  queues.set_urgent(1, {"stop"});
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(queues.push(press(1, "!")));
  EXPECT_TRUE(queues.next(Lane::kUrgent, 0.0));
  EXPECT_FALSE(queues.next(Lane::kUrgent, 0.0));
  int taken = 0;
  while (queues.push(press(1, std::to_string(taken % 2)))) ++taken;
  EXPECT_EQ(taken, 16);
}

TEST(ClientQueues, PressesOfADebtorAreServedToo) {
  auto queues = queues_of(1);
  queues.set_urgent(1, {"stop"});
  queues.charge(1, 1e9, 0.0);
  ASSERT_TRUE(queues.push(press(1, "!")));
  EXPECT_TRUE(queues.next(Lane::kUrgent, 0.0));
}

TEST(ClientQueues, LetAClientGoAfterItsPressesAndBeforeTheOthersFrames) {
  auto queues = queues_of(2);
  queues.set_urgent(1, {"stop"});
  ASSERT_TRUE(queues.push(say(1, "goal")));
  ASSERT_TRUE(queues.push(press(1, "!")));
  queues.leave(1);
  EXPECT_FALSE(queues.next(Lane::kLeft, 0.0)) << "its press comes first";
  EXPECT_FALSE(queues.next(Lane::kUsual, 0.0)) << "it no longer counts as a usual client";
  EXPECT_EQ(queues.next(Lane::kUrgent, 0.0)->client, 1U);
  EXPECT_EQ(queues.next(Lane::kLastWords, 0.0)->bytes, "goal");
  const auto left = queues.next(Lane::kLeft, 0.0);
  ASSERT_TRUE(left);
  EXPECT_EQ(left->client, 1U);
  EXPECT_EQ(left->kind, Kind::kLeft);
  EXPECT_FALSE(queues.next(Lane::kLeft, 0.0));
}

TEST(ClientQueues, ForgetPendingRequestsOfADisconnectedClient) {
  auto queues = queues_of(1);
  ASSERT_TRUE(queues.push(say(1, "goal")));
  queues.leave(1);
  EXPECT_TRUE(queues.next(Lane::kLeft, 0.0));
  EXPECT_FALSE(queues.next(Lane::kLastWords, 0.0));
  EXPECT_FALSE(queues.push(say(1, "more")));
}

TEST(ClientQueues, SayNothingOfAClientThatLeftBeforeItsArrivalWasTaken) {
  ClientQueues queues{{}};
  queues.join(1, 0.0);
  ASSERT_TRUE(queues.push(say(1, "a")));
  EXPECT_FALSE(queues.next(Lane::kUsual, 0.0)) << "its arrival is handled first";
  queues.leave(1);
  for (const Lane lane : {Lane::kJoined, Lane::kLeft, Lane::kUsual, Lane::kLastWords})
    EXPECT_FALSE(queues.next(lane, 0.0));
}

}  // namespace
}  // namespace tandem
