// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/wake_up.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <optional>
#include <thread>

#include "support/spin_until.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

using test::kTimeout;

// Notifies after this, which is long enough for another thread to begin to wait.
void pause() { std::this_thread::sleep_for(std::chrono::milliseconds{50}); }

// How long a wait takes [s].
double time_of_wait(rt::WakeUp& wake_up, double max_wait = kTimeout) {
  const double start = rt::steady_seconds();
  wake_up.wait(max_wait);
  return rt::steady_seconds() - start;
}

TEST(WakeUp, EndsTheNextWaitAtOnceAndOnlyThat) {
  const auto wake_up = std::make_shared<rt::WakeUp>();
  wake_up->notify();
  wake_up->notify();
  EXPECT_LT(time_of_wait(*wake_up), kTimeout / 2);
  EXPECT_GE(time_of_wait(*wake_up, 0.05), 0.05);
}

TEST(WakeUp, EndsTheWaitOfAnotherThread) {
  const auto wake_up = std::make_shared<rt::WakeUp>();
  std::thread other{[&] {
    pause();
    wake_up->notify();
  }};
  EXPECT_LT(time_of_wait(*wake_up), kTimeout / 2);
  other.join();
}

TEST(WakeUp, IsDeferredUntilTheOutermostDeferralEnds) {
  const auto wake_up = std::make_shared<rt::WakeUp>();
  std::atomic<bool> may_wake = false;
  std::thread other{[&] {
    pause();
    std::optional<rt::WakeUp::Deferral> outer{std::in_place};
    {
      const rt::WakeUp::Deferral inner;
      wake_up->notify();
    }
    pause();
    may_wake = true;
    outer.reset();
  }};
  EXPECT_LT(time_of_wait(*wake_up), kTimeout / 2);
  EXPECT_TRUE(may_wake);
  other.join();
}

TEST(WakeUp, IsNotHeldUpByTheDeferralOfAnotherThread) {
  const auto wake_up = std::make_shared<rt::WakeUp>();
  std::atomic<bool> deferred = false, done = false;
  std::thread slow{[&] {
    const rt::WakeUp::Deferral deferral;
    wake_up->notify();
    deferred = true;
    deferred.notify_one();
    done.wait(false);
  }};
  std::thread fast{[&] {
    deferred.wait(false);
    wake_up->notify();
  }};
  const double waited = time_of_wait(*wake_up);
  done = true;
  done.notify_one();
  EXPECT_LT(waited, kTimeout / 2);
  slow.join();
  fast.join();
}

TEST(WakeUp, OfAGroupIsNotHeldUpByTheDeferralOfAnotherThread) {
  const auto group = std::make_shared<rt::WakeUp>(), member = std::make_shared<rt::WakeUp>();
  member->join(group);
  std::promise<void> deferred, done;
  std::thread slow{[&] {
    const rt::WakeUp::Deferral deferral;
    member->notify();
    deferred.set_value();
    done.get_future().wait();
  }};
  deferred.get_future().wait();
  std::thread fast{[&] {
    const rt::WakeUp::Deferral deferral;
    member->notify();
  }};
  const double waited = time_of_wait(*group);
  done.set_value();
  EXPECT_LT(waited, kTimeout / 2);
  EXPECT_TRUE(member->take());
  EXPECT_FALSE(member->take());
  slow.join();
  fast.join();
}

TEST(WakeUp, MayGoWhileItIsDeferred) {
  const rt::WakeUp::Deferral deferral;
  std::make_shared<rt::WakeUp>()->notify();
}

// A thread that begins to wait finds what another one has deferred, and does not sleep.
TEST(WakeUp, FindsADeferredNotificationWhenItBeginsToWait) {
  const auto wake_up = std::make_shared<rt::WakeUp>();
  const rt::WakeUp::Deferral deferral;
  wake_up->notify();
  EXPECT_LT(time_of_wait(*wake_up), kTimeout / 2);
}

}  // namespace
}  // namespace tandem
