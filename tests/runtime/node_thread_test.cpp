// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/node_thread.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <future>
#include <set>
#include <thread>
#include <vector>

#include "support/private_domain.hpp"
#include "support/real_time.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/local_bus.hpp"
#include "tandem/runtime/real_time.hpp"

namespace tandem {
namespace {

using std_msgs::msg::Float64;
using test::kTimeout;

constexpr rt::Topic<Float64> kFirst{"first"}, kSecond{"second"};

// Waits for the value of `future`.
template <class T>
[[nodiscard]] bool is_there(const std::future<T>& future) {
  return future.wait_for(std::chrono::duration<double>(kTimeout)) == std::future_status::ready;
}

TEST(NodeThread, CarriesMessagesAndTimersOfItsNodes) {
  rt::Node source{"source"}, relay{"relay"}, sink{"sink"};
  std::set<std::thread::id> threads;
  std::promise<double> arrived;
  auto arrival = arrived.get_future();
  const auto first = source.create_publisher(kFirst);
  const auto second = relay.create_publisher(kSecond);
  double value = 0.0;
  const auto timer = source.create_wall_timer(0.01, [&] {
    threads.insert(std::this_thread::get_id());
    Float64 message;
    message.data(++value);
    first.publish(message);
  });
  const auto passes = relay.create_subscription(kFirst, [&](const Float64& message) {
    threads.insert(std::this_thread::get_id());
    second.publish(message);
  });
  const auto ends = sink.create_subscription(kSecond, [&](const Float64& message) {
    threads.insert(std::this_thread::get_id());
    if (message.data() == 3.0) arrived.set_value(message.data());
  });
  rt::NodeThread thread{"together", {&source, &relay, &sink}};
  EXPECT_TRUE(is_there(arrival));
  for (rt::Node* node : {&source, &relay, &sink}) node->stop();
  thread.join();
  EXPECT_EQ(threads.size(), 1U);
}

TEST(NodeThread, GoesOnWithTheOthersWhenOneStops) {
  rt::Node one{"one"}, other{"other"};
  std::promise<void> went_on;
  const auto going_on = went_on.get_future();
  int beats = 0;
  const auto stops = one.create_wall_timer(0.01, [&] { one.stop(); });
  const auto beat = other.create_wall_timer(0.01, [&] {
    if (one.stopped() && ++beats == 3) went_on.set_value();
  });
  const rt::NodeThread thread{"together", {&one, &other}};
  EXPECT_TRUE(is_there(going_on));
}

// A worker, and a message of another thread, wake the thread while all of its nodes wait.
TEST(NodeThread, IsWokenFromOutside) {
  rt::Node one{"one"}, other{"other"}, outside{"outside"};
  std::promise<void> worked, heard;
  const auto working = worked.get_future(), hearing = heard.get_future();
  const auto worker = one.create_worker([] { return std::nullopt; }, [&] { worked.set_value(); });
  const auto subscription =
      other.create_subscription(kFirst, [&](const auto&) { heard.set_value(); });
  const auto publisher = outside.create_publisher(kFirst);
  const rt::NodeThread thread{"together", {&one, &other}};
  worker.wake();
  EXPECT_TRUE(is_there(working));
  publisher.publish({});
  EXPECT_TRUE(is_there(hearing));
}

// Policy and priority of the calling thread, and the policy of a thread that it starts.
struct Scheduling {
  int policy, priority, inherited;
};

Scheduling scheduling() {
  sched_param param{};
  sched_getparam(0, &param);
  int inherited = -1;
  std::thread{[&] { inherited = sched_getscheduler(0); }}.join();
  return {sched_getscheduler(0) & ~SCHED_RESET_ON_FORK, param.sched_priority, inherited};
}

TEST(NodeThread, HasARealTimePriority) {
  if (!test::may_use_real_time()) GTEST_SKIP() << "no right to real-time priorities";
  rt::Node node{"urgent"};
  std::promise<Scheduling> seen;
  auto seeing = seen.get_future();
  const auto worker =
      node.create_worker([] { return std::nullopt; }, [&] { seen.set_value(scheduling()); });
  const rt::NodeThread thread{"urgent", {&node}, 2};
  worker.wake();
  ASSERT_TRUE(is_there(seeing));
  const Scheduling found = seeing.get();
  EXPECT_EQ(found.policy, SCHED_FIFO);
  EXPECT_EQ(found.priority, 2);
  EXPECT_EQ(found.inherited, SCHED_OTHER);
}

TEST(RealTime, IsGivenToTheThreadsOfDds) {
  if (!test::may_use_real_time()) GTEST_SKIP() << "no right to real-time priorities";
  rt::use_real_time_for_dds(2);
  {
    const rt::Node node{"urgent"};
    EXPECT_GE(test::threads_with_priority(2), 3);  // events, discovery, messages
    EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
  }
  rt::use_real_time_for_dds(0);
  const rt::Node node{"calm"};
  EXPECT_EQ(test::threads_with_priority(2), 0);
}

// The node works all the same.
TEST(RealTime, ARefusalIsLoggedWithItsRemedy) {
  testing::internal::CaptureStderr();
  std::thread{[] { rt::use_real_time("urgent", 100); }}.join();  // no such priority
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("thread urgent has no real-time priority 100"), std::string::npos) << log;
  EXPECT_NE(log.find("LimitRTPRIO=100"), std::string::npos) << log;
}

TEST(NodeThread, RefusesANodeOfALocalBus) {
  rt::Node node{rt::NodeOptions{.name = "local", .bus = std::make_shared<rt::LocalBus>()}};
  try {
    const rt::NodeThread thread{"local", {&node}};
    FAIL() << "not refused";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "/local is on a LocalBus, which runs it without a thread");
  }
}

}  // namespace
}  // namespace tandem
