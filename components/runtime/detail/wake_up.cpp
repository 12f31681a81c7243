// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/wake_up.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

namespace tandem::runtime {
namespace {

thread_local bool is_deferring = false;
thread_local std::vector<std::shared_ptr<WakeUp>> deferred;

}  // namespace

WakeUp::Deferral::Deferral() : is_outermost_{!std::exchange(is_deferring, true)} {}

WakeUp::Deferral::~Deferral() {
  if (!is_outermost_) return;
  is_deferring = false;
  for (const auto& wake_up : deferred) wake_up->wake();
  deferred.clear();
}

// Each thread defers for itself, also what another one has notified before: that one's deferral may
// end later.
void WakeUp::notify() {
  std::shared_ptr<WakeUp> group;
  {
    const std::lock_guard lock{mutex_};
    notified_ = true;
    group = group_;
  }
  if (group) return group->notify();
  if (!is_deferring) return wake();
  const auto self = shared_from_this();
  if (std::find(deferred.begin(), deferred.end(), self) == deferred.end()) deferred.push_back(self);
}

// A notification that another thread deferred is not waited for.
void WakeUp::wake() {
  {
    const std::lock_guard lock{mutex_};
    if (!notified_ || std::exchange(woken_, true)) return;
  }
  changed_.notify_one();
}

void WakeUp::wait(double max_wait) {
  std::unique_lock lock{mutex_};
  const auto is_notified = [this] { return notified_.load(); };
  if (std::isinf(max_wait))
    changed_.wait(lock, is_notified);
  else if (max_wait > 0.0)
    changed_.wait_for(lock, std::chrono::duration<double>(max_wait), is_notified);
  notified_ = woken_ = false;
}

void WakeUp::join(std::shared_ptr<WakeUp> group) {
  const std::lock_guard lock{mutex_};
  group_ = std::move(group);
}

bool WakeUp::take() { return notified_ && notified_.exchange(false); }

}  // namespace tandem::runtime
