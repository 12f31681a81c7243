// SPDX-License-Identifier: Apache-2.0
// Private to runtime/.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "tandem/runtime/detail/ports.hpp"
#include "tandem/runtime/detail/wake_up.hpp"
#include "tandem/runtime/worker.hpp"

namespace tandem::runtime {

/// A worker with a thread of its own.
class ThreadWorker final : public WorkerPort {
 public:
  /// Notifies `node` when work has ended that `done` is to be called after.
  ThreadWorker(Worker::Work work, Worker::Done done, std::shared_ptr<WakeUp> node);
  ~ThreadWorker() override { close(); }
  ThreadWorker(const ThreadWorker&) = delete;
  ThreadWorker& operator=(const ThreadWorker&) = delete;

  void wake() override;
  void close() override;

  /// Whether finish() is to be called.
  [[nodiscard]] bool is_done() const { return done_ && has_worked_; }
  /// Calls `done`, if the work has ended since the last call. On the node's thread.
  void finish();

 private:
  void run();

  Worker::Work work_;
  Worker::Done done_;
  std::shared_ptr<WakeUp> node_;
  std::atomic<bool> has_worked_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool woken_ = false;
  bool closed_ = false;
  std::thread thread_;
};

}  // namespace tandem::runtime
