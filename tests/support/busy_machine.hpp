// SPDX-License-Identifier: Apache-2.0
// Tells what other programs take of the processor's time, so that a test of real time can allow for
// it.
#pragma once

#include <time.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace tandem::test {

/// While it lives, a thread computes as a planning cycle does: `kWork` of processor time every
/// `kPeriod`. A round is late if it takes longer than `budget` by the clock, which on a machine
/// with nothing else to do it never does.
class BusyMachine {
 public:
  /// `budget`: [s].
  explicit BusyMachine(double budget) : budget_{budget}, thread_{[this] { run(); }} {}
  ~BusyMachine() {
    done_ = true;
    thread_.join();
  }
  BusyMachine(const BusyMachine&) = delete;
  BusyMachine& operator=(const BusyMachine&) = delete;

  /// Late rounds, of all.
  [[nodiscard]] double late_share() const {
    return rounds_ > 0 ? static_cast<double>(late_) / static_cast<double>(rounds_) : 0.0;
  }

 private:
  static constexpr double kWork = 0.005;  // [s] above that of a usual cycle
  static constexpr std::chrono::milliseconds kPeriod{50};

  static double seconds(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }
  void run() {
    for (auto next = std::chrono::steady_clock::now(); !done_; next += kPeriod) {
      std::this_thread::sleep_until(next);
      const double began = seconds(CLOCK_MONOTONIC);
      const double end = seconds(CLOCK_THREAD_CPUTIME_ID) + kWork;
      while (seconds(CLOCK_THREAD_CPUTIME_ID) < end) {
      }
      if (seconds(CLOCK_MONOTONIC) - began > budget_) ++late_;
      ++rounds_;
    }
  }

  double budget_;
  std::atomic<bool> done_{false};
  std::atomic<long> rounds_{0}, late_{0};
  std::thread thread_;  // last: it uses the others
};

}  // namespace tandem::test
