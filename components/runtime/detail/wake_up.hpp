// SPDX-License-Identifier: Apache-2.0
// Wakes the thread of a node. Private to runtime/.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// What one thread waits for and others notify. Made by std::make_shared.
class TANDEM_EXPORT_FOR_TESTS WakeUp : public std::enable_shared_from_this<WakeUp> {
 public:
  /// While it exists, its thread wakes no other: what it notifies wakes at the end, once. A writer
  /// wakes the receivers of its process after it has released the locks that they need.
  class TANDEM_EXPORT_FOR_TESTS Deferral {
   public:
    Deferral();
    ~Deferral();
    Deferral(const Deferral&) = delete;
    Deferral& operator=(const Deferral&) = delete;

   private:
    bool is_outermost_;
  };

  /// Has wait() return, now or when it is called. Thread-safe.
  void notify();
  /// Returns once notify() was called since the last wait(), or after `max_wait` [s].
  void wait(double max_wait);

  /// From now on notify() notifies `group`, on which a thread waits for several of these.
  void join(std::shared_ptr<WakeUp> group);
  /// Whether notify() was called since the last call. On the thread that waits for the group.
  [[nodiscard]] bool take();

 private:
  void wake();

  std::mutex mutex_;
  std::shared_ptr<WakeUp> group_;
  std::condition_variable changed_;
  std::atomic<bool> notified_ = false;
  bool woken_ = false;  // the thread has been woken for it, so that nobody else needs to
};

}  // namespace tandem::runtime
