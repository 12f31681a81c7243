// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <semaphore>
#include <thread>
#include <vector>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using test::spin_until;

using test::kTimeout;
const rt::Topic<rosgraph_msgs::msg::Clock> kClockTopic{"/clock", rt::kClock};

TEST(Beat, SkipsMissedBeatsAndKeepsItsGrid) {
  rt::Beat beat{0.0, 0.1};
  EXPECT_FALSE(beat.due(0.09));
  EXPECT_TRUE(beat.due(0.1));
  EXPECT_FALSE(beat.due(0.15));
  EXPECT_TRUE(beat.due(5.03));  // 49 beats late: one
  EXPECT_FALSE(beat.due(5.03));
  EXPECT_NEAR(beat.next(), 5.1, 1e-9);
}

TEST(Beat, RestartsAfterAClockReset) {
  rt::Beat beat{100.0, 0.1};
  EXPECT_FALSE(beat.due(0.0));
  EXPECT_TRUE(beat.due(0.1));
}

TEST(Beat, LeavesOutTicksAndKeepsItsGrid) {
  rt::Beat beat{0.0, 0.1};
  beat.skip_until(0.45);
  EXPECT_NEAR(beat.next(), 0.5, 1e-9);
  beat.skip_until(0.2);  // earlier than what is left out already
  EXPECT_NEAR(beat.next(), 0.5, 1e-9);
  EXPECT_FALSE(beat.due(0.1));  // no jump of the clock
  EXPECT_FALSE(beat.due(0.45));
  EXPECT_TRUE(beat.due(0.5));
  EXPECT_NEAR(beat.next(), 0.6, 1e-9);
}

TEST(Beat, SeesAClockResetWhileItLeavesOutTicks) {
  rt::Beat beat{100.0, 0.1};
  beat.skip_until(101.0);
  EXPECT_FALSE(beat.due(0.0));
  EXPECT_TRUE(beat.due(0.1));
}

TEST(Beat, SeesAClockResetAfterLeavingOutTicksForLong) {
  rt::Beat beat{0.0, 0.1};
  for (double now = 0.05; now < 100.0; now += 0.05) {
    beat.skip_until(now + 0.2);
    ASSERT_FALSE(beat.due(now));
  }
  EXPECT_FALSE(beat.due(50.0));
  EXPECT_TRUE(beat.due(50.1));
}

TEST(Beat, TakesBackTheTicksThatItLeavesOut) {
  rt::Beat beat{0.0, 0.1};
  EXPECT_EQ(beat.skip_until(0.45), 4);
  EXPECT_EQ(beat.skip_until(0.45), 0) << "those are left out already";
  beat.resume(0.25);
  EXPECT_NEAR(beat.next(), 0.3, 1e-9);
  beat.resume(0.25);  // none is left out
  EXPECT_NEAR(beat.next(), 0.3, 1e-9);
  EXPECT_TRUE(beat.due(0.31));
  EXPECT_EQ(beat.skip_until(0.55), 2);
  beat.resume(0.32);
  EXPECT_NEAR(beat.next(), 0.4, 1e-9);
}

// A beat that is asked only when it is not idle ticks as one that is always asked.
TEST(Beat, IsIdleWhereAskingItChangesNothing) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> step{-0.02, 0.12};
  rt::Beat asked{0.0, 0.1}, spared{0.0, 0.1};
  double now = 0.0;
  int idle = 0, ticks = 0;
  for (int i = 0; i < 10'000; ++i) {
    now += i % 1000 == 999 ? -5.0 : step(random);
    if (i % 17 == 0) {
      ASSERT_EQ(asked.skip_until(now + 0.3), spared.skip_until(now + 0.3));
    }
    const bool is_due = asked.due(now);
    if (spared.is_idle(now)) {
      ++idle;
      ASSERT_FALSE(is_due);
    } else {
      ASSERT_EQ(spared.due(now), is_due);
    }
    ticks += is_due ? 1 : 0;
    ASSERT_DOUBLE_EQ(asked.next(), spared.next());
  }
  EXPECT_GT(idle, 1000);
  EXPECT_GT(ticks, 1000);
}

TEST(Beat, RefusesAPeriodThatIsNotPositive) {
  EXPECT_THROW(rt::Beat(0.0, 0.0), std::invalid_argument);
  EXPECT_THROW(rt::Beat(0.0, -1.0), std::invalid_argument);
  EXPECT_THROW(rt::Beat(0.0, 0.0 / 0.0), std::invalid_argument);
}

TEST(Timer, FiresAtItsRate) {
  rt::Node node{"timed"};
  int beats = 0;
  const auto timer = node.create_timer(0.01, [&] { ++beats; });
  const double start = rt::steady_seconds();
  ASSERT_TRUE(spin_until([&] { return beats == 20; }, kTimeout, node));
  EXPECT_GE(rt::steady_seconds() - start, 0.199);
}

TEST(Timer, LeavesOutTicksThatNobodyNeeds) {
  rt::Node node{"late"};
  const double start = rt::steady_seconds();
  std::vector<double> ticks;
  auto timer = node.create_wall_timer(0.01, [&] { ticks.push_back(rt::steady_seconds() - start); });
  timer.skip_until(start + 0.1);
  ASSERT_TRUE(spin_until([&] { return ticks.size() == 2; }, kTimeout, node));
  EXPECT_GE(ticks[0], 0.1);
}

// In the same pass, unless the thread is interrupted between two of them.
TEST(Timer, ASlowOneRunsWhenAFastOneHasWokenTheThread) {
  constexpr double kFast = 0.03;  // [s]
  rt::Node node{"slow"};
  double fast_ran = 0.0;
  std::vector<double> gaps;  // [s] from the fast one to the slow one
  const auto fast = node.create_wall_timer(kFast, [&] { fast_ran = rt::steady_seconds(); });
  const double until = rt::steady_seconds() + kFast / 2;  // so that they are not in step
  ASSERT_FALSE(spin_until([] { return false; }, until - rt::steady_seconds(), node));
  const auto slow = node.create_wall_timer(
      rt::Beat::kSlow, [&] { gaps.push_back(rt::steady_seconds() - fast_ran); });
  const double end = rt::steady_seconds() + kTimeout;
  while (gaps.size() < 4 && rt::steady_seconds() < end)
    node.spin_some(kTimeout);  // spin_until() would wake the node
  ASSERT_EQ(gaps.size(), 4U);
  EXPECT_LT(*std::min_element(gaps.begin(), gaps.end()), kFast / 10);
}

TEST(Timer, StopsWhenItsHandleGoes) {
  rt::Node node{"brief"};
  int beats = 0, others = 0;
  rt::Timer timer;
  timer = node.create_timer(0.005, [&] {
    ++beats;
    timer = {};
  });
  const auto other = node.create_timer(0.01, [&] { ++others; });
  ASSERT_TRUE(spin_until([&] { return others == 3; }, kTimeout, node));
  EXPECT_EQ(beats, 1);
}

class SimTime : public testing::Test {
 protected:
  void set_clock(double seconds) {
    rosgraph_msgs::msg::Clock message;
    message.clock(rt::to_stamp(std::llround(seconds * 1e9)));
    clock_.publish(message);
  }

  rt::Node source_{"clock_source"};
  rt::Publisher<rosgraph_msgs::msg::Clock> clock_{source_.create_publisher(kClockTopic)};
  rt::Node node_{rt::NodeOptions{.name = "simulated", .use_sim_time = true}};
};

TEST_F(SimTime, IsZeroBeforeTheFirstClockThenFollowsIt) {
  EXPECT_EQ(node_.now(), 0.0);
  ASSERT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  set_clock(12.5);
  ASSERT_TRUE(spin_until([&] { return node_.now() > 0.0; }, kTimeout, node_));
  EXPECT_EQ(node_.now(), 12.5);
  EXPECT_EQ(node_.stamp().sec(), 12);
  EXPECT_EQ(node_.stamp().nanosec(), 500'000'000U);
}

TEST_F(SimTime, TellsThatTheClockIsSilent) {
  ASSERT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  ASSERT_TRUE(spin_until([&] { return node_.clock_is_silent(); }, kTimeout, node_));
  const double sent = rt::steady_seconds();  // the node may receive it before set_clock() returns
  set_clock(12.5);
  ASSERT_TRUE(spin_until([&] { return !node_.clock_is_silent(); }, kTimeout, node_));
  ASSERT_TRUE(spin_until([&] { return node_.clock_is_silent(); }, kTimeout, node_));
  EXPECT_GT(rt::steady_seconds() - sent, rt::Node::kClockSilence);
  EXPECT_FALSE(source_.clock_is_silent()) << "it has no simulated time";
}

TEST_F(SimTime, DrivesTimersButNotWallTimers) {
  int beats = 0, wall_beats = 0;
  const auto timer = node_.create_timer(0.1, [&] { ++beats; });
  const auto wall = node_.create_wall_timer(0.01, [&] { ++wall_beats; });
  ASSERT_TRUE(spin_until([&] { return wall_beats > 20; }, kTimeout, node_));
  EXPECT_EQ(beats, 0);
  ASSERT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  for (int i = 1; i <= 10; ++i) {
    set_clock(0.1 * i + 0.001);
    ASSERT_TRUE(spin_until([&] { return beats == i; }, kTimeout, node_)) << i;
  }
}

TEST_F(SimTime, ReportsThatTheClockJumpedBackOnceAndBeforeAnythingElse) {
  int jumps = 0;
  double now = -1.0;
  const auto jump = node_.on_time_jump([&] {
    ++jumps;
    now = node_.now();
  });
  auto cancelled = node_.on_time_jump([&] { FAIL(); });
  cancelled.reset();
  ASSERT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  for (const double time : {12.5, 12.75, 3.0, 3.25}) {  // exact in binary
    set_clock(time);
    ASSERT_TRUE(spin_until([&] { return node_.now() == time; }, kTimeout, node_)) << time;
  }
  EXPECT_EQ(jumps, 1);
  EXPECT_EQ(now, 3.0);
}

TEST_F(SimTime, ReportsAJumpBackThatALaterTimeHides) {
  int jumps = 0;
  const auto jump = node_.on_time_jump([&] { ++jumps; });
  ASSERT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  for (const double time : {12.5, 3.0, 13.0}) set_clock(time);
  ASSERT_TRUE(spin_until([&] { return node_.now() == 13.0; }, kTimeout, node_));
  EXPECT_EQ(jumps, 1);
}

TEST_F(SimTime, IsReceivedOnceForAllNodesOfAProcess) {
  rt::Node second{rt::NodeOptions{.name = "second", .use_sim_time = true}};
  rt::Node third{rt::NodeOptions{.name = "third", .use_sim_time = true}};
  ASSERT_TRUE(spin_until([&] { return clock_.matched() >= 1; }, kTimeout, node_));
  set_clock(12.5);
  const auto all_have_it = [&] {
    return node_.now() == 12.5 && second.now() == 12.5 && third.now() == 12.5;
  };
  ASSERT_TRUE(spin_until(all_have_it, kTimeout, node_, second, third));
  EXPECT_EQ(clock_.matched(), 1);
}

TEST_F(SimTime, IsKnownAtOnceToANodeThatIsMadeLater) {
  ASSERT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  set_clock(12.5);
  ASSERT_TRUE(spin_until([&] { return node_.now() == 12.5; }, kTimeout, node_));
  ASSERT_TRUE(spin_until([&] { return node_.clock_is_silent(); }, kTimeout, node_));
  int jumps = 0;
  rt::Node late{rt::NodeOptions{.name = "late", .use_sim_time = true}};
  const auto jump = late.on_time_jump([&] { ++jumps; });
  EXPECT_EQ(late.now(), 12.5);
  EXPECT_FALSE(late.clock_is_silent()) << "silence counts from the node's start";
  set_clock(13.0);
  ASSERT_TRUE(spin_until([&] { return late.now() == 13.0; }, kTimeout, late));
  EXPECT_EQ(jumps, 0);
}

TEST_F(SimTime, OfOneTopicDoesNotReachTheNodesOfAnother) {
  rt::Node other{
      rt::NodeOptions{.name = "other", .remappings = {{"/clock", "/other"}}, .use_sim_time = true}};
  const auto other_clock =
      source_.create_publisher(rt::Topic<rosgraph_msgs::msg::Clock>{"/other", rt::kClock});
  const auto both_match = [&] { return clock_.matched() == 1 && other_clock.matched() == 1; };
  ASSERT_TRUE(spin_until(both_match, kTimeout, node_, other));
  set_clock(12.5);
  ASSERT_TRUE(spin_until([&] { return node_.now() == 12.5; }, kTimeout, node_, other));
  EXPECT_EQ(other.now(), 0.0);
}

// Fires at the first time at or after each beat, though the node sleeps in between. The clock waits
// for the beats, so that a busy machine delays none of them.
TEST_F(SimTime, WakesANodeOnlyForItsTimers) {
  ASSERT_TRUE(spin_until([&] { return clock_.matched() == 1; }, kTimeout, node_));
  std::vector<double> beats;
  std::counting_semaphore<> beaten{0};
  const auto timer = node_.create_timer(0.1, [&] {
    beats.push_back(node_.now());
    beaten.release();
  });
  const auto waits = [] {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nvcsw;
  };
  constexpr int kTimes = 400;
  std::thread clock{[&] {
    for (int i = 1; i <= kTimes; ++i) {
      set_clock(0.001 * i);
      if (i % 100 == 0 && !beaten.try_acquire_for(std::chrono::seconds{20})) break;
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
    node_.stop();
  }};
  const long before = waits();
  node_.spin();
  const long waited = waits() - before;
  clock.join();
  EXPECT_LT(waited, kTimes / 4);
  ASSERT_EQ(beats.size(), 4U);
  for (std::size_t i = 0; i < beats.size(); ++i)
    EXPECT_NEAR(beats[i], 0.1 * static_cast<double>(i + 1), 1e-9) << i;
}

TEST(Node, UseSimTimeIsAParameter) {
  rt::NodeOptions options{.name = "by_parameter"};
  options.parameters.values["use_sim_time"] = {"true", "test"};
  rt::Node node{options};
  EXPECT_TRUE(node.use_sim_time());
  EXPECT_NO_THROW(node.check_parameters());
}

TEST(Node, StopEndsSpinFromACallback) {
  rt::Node node{"stopped"};
  const auto timer = node.create_timer(0.02, [&] { node.stop(); });
  node.spin();
  EXPECT_TRUE(node.stopped());
}

}  // namespace
}  // namespace tandem
