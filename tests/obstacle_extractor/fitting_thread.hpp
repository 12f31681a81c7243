// SPDX-License-Identifier: Apache-2.0
// Runs a BackgroundExtractor's work on a thread, as a node on DDS does.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "tandem/obstacle_extractor/background_extractor.hpp"

namespace tandem::test {

class FittingThread {
 public:
  explicit FittingThread(const ExtractorParams& params) : shapes{params, [this] { wake(); }} {
    thread_ = std::thread{[this] { run(); }};
  }
  ~FittingThread() {
    {
      const std::lock_guard lock{mutex_};
      ends_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }
  FittingThread(const FittingThread&) = delete;
  FittingThread& operator=(const FittingThread&) = delete;

  BackgroundExtractor shapes;

 private:
  void wake() {
    {
      const std::lock_guard lock{mutex_};
      is_woken_ = true;
    }
    changed_.notify_one();
  }

  void run() {
    std::optional<double> pause;  // [s]
    std::unique_lock lock{mutex_};
    while (true) {
      const auto is_due = [this] { return is_woken_ || ends_; };
      if (pause)
        changed_.wait_for(lock, std::chrono::duration<double>(*pause), is_due);
      else
        changed_.wait(lock, is_due);
      if (ends_) return;
      is_woken_ = false;
      lock.unlock();
      pause = shapes.work();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_woken_ = false;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace tandem::test
