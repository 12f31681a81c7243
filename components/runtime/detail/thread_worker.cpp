// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/thread_worker.hpp"

#include <chrono>
#include <optional>
#include <utility>

namespace tandem::runtime {

ThreadWorker::ThreadWorker(Worker::Work work, Worker::Done done, std::shared_ptr<WakeUp> node)
    : work_{std::move(work)}, done_{std::move(done)}, node_{std::move(node)}, thread_{[this] {
        run();
      }} {}

void ThreadWorker::wake() {
  {
    const std::lock_guard lock{mutex_};
    woken_ = true;
  }
  changed_.notify_one();
}

void ThreadWorker::close() {
  {
    const std::lock_guard lock{mutex_};
    closed_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

// `closed_` is set on the node's thread only.
void ThreadWorker::finish() {
  if (has_worked_.exchange(false) && done_ && !closed_) done_();
}

void ThreadWorker::run() {
  std::optional<double> pause;  // [s] until the next call if nobody wakes it
  std::unique_lock lock{mutex_};
  while (true) {
    const auto is_due = [this] { return woken_ || closed_; };
    if (pause)
      changed_.wait_for(lock, std::chrono::duration<double>(*pause), is_due);
    else
      changed_.wait(lock, is_due);
    if (closed_) return;
    woken_ = false;
    lock.unlock();
    pause = work_();
    has_worked_ = true;
    if (done_) node_->notify();
    lock.lock();
  }
}

}  // namespace tandem::runtime
