// SPDX-License-Identifier: Apache-2.0
// Private to runtime/.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "tandem/runtime/detail/ports.hpp"
#include "tandem/runtime/worker.hpp"

namespace tandem::runtime {

/// A worker with a thread of its own.
class ThreadWorker final : public WorkerPort {
 public:
  explicit ThreadWorker(Worker::Work work);
  ~ThreadWorker() override { close(); }
  ThreadWorker(const ThreadWorker&) = delete;
  ThreadWorker& operator=(const ThreadWorker&) = delete;

  void wake() override;
  void close() override;

 private:
  void run();

  Worker::Work work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool woken_ = false;
  bool closed_ = false;
  std::thread thread_;
};

}  // namespace tandem::runtime
