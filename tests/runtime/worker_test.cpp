// SPDX-License-Identifier: Apache-2.0
// Workers of nodes on DDS, which have threads of their own; of others see local_bus_test.cpp.
#include "tandem/runtime/worker.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <thread>

#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using test::kTimeout;
using test::spin_until;

TEST(Worker, WorksOnAnotherThreadOnceForEachWaking) {
  rt::Node node{"worker"};
  std::atomic<int> done = 0;
  std::atomic<std::thread::id> where{};
  const auto worker = node.create_worker([&] {
    where = std::this_thread::get_id();
    ++done;
    return std::nullopt;
  });
  worker.wake();
  ASSERT_TRUE(spin_until([&] { return done == 1; }, kTimeout, node));
  EXPECT_NE(where.load(), std::this_thread::get_id());
  worker.wake();
  ASSERT_TRUE(spin_until([&] { return done == 2; }, kTimeout, node));
}

TEST(Worker, GoesOnUnaskedAfterItsPause) {
  rt::Node node{"worker"};
  std::atomic<int> done = 0;
  const auto worker = node.create_worker([&]() -> std::optional<double> {
    if (++done == 3) return std::nullopt;
    return done == 1 ? 0.0 : 0.01;
  });
  worker.wake();
  ASSERT_TRUE(spin_until([&] { return done == 3; }, kTimeout, node));
}

TEST(Worker, TellsTheNodesThreadThatItHasWorked) {
  rt::Node node{"worker"};
  std::atomic<int> works = 0;
  int told = 0;
  std::thread::id where;
  const auto worker = node.create_worker(
      [&] {
        ++works;
        return std::nullopt;
      },
      [&] {
        where = std::this_thread::get_id();
        ++told;
      });
  worker.wake();
  ASSERT_TRUE(spin_until([&] { return told == 1; }, kTimeout, node));
  EXPECT_EQ(works, 1);
  EXPECT_EQ(where, std::this_thread::get_id());
  worker.wake();
  ASSERT_TRUE(spin_until([&] { return told == 2; }, kTimeout, node));
}

TEST(Worker, ThatHasGoneTellsNothing) {
  rt::Node node{"worker"};
  std::promise<void> has_worked;
  bool is_told = false;
  std::optional<rt::Worker> worker = node.create_worker(
      [&] {
        has_worked.set_value();
        return std::nullopt;
      },
      [&] { is_told = true; });
  worker->wake();
  // Not by spinning the node, which would tell it.
  ASSERT_EQ(has_worked.get_future().wait_for(std::chrono::duration<double>(kTimeout)),
            std::future_status::ready);
  worker.reset();
  node.spin_some(0.0);
  EXPECT_FALSE(is_told);
}

TEST(Worker, IsWaitedForWhenItGoes) {
  rt::Node node{"worker"};
  std::atomic<bool> begun = false, may_end = false, ended = false;
  std::optional<rt::Worker> worker = node.create_worker([&] {
    begun = true;
    while (!may_end) std::this_thread::yield();
    ended = true;
    return std::nullopt;
  });
  worker->wake();
  ASSERT_TRUE(spin_until([&] { return begun.load(); }, kTimeout, node));
  std::thread release{[&] { may_end = true; }};
  worker.reset();
  EXPECT_TRUE(ended);
  release.join();
}

}  // namespace
}  // namespace tandem
