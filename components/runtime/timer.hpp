// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

class NodeCore;

/// A fixed-period schedule. Missed ticks are skipped, never replayed.
class TANDEM_EXPORT Beat {
 public:
  /// The first tick is one period [s] after `start` [s]. Throws std::invalid_argument unless
  /// period > 0.
  Beat(double start, double period);

  /// Whether due() would return false and change nothing.
  [[nodiscard]] bool is_idle(double now) const {
    return now < next() && skipped_ == 0.0 && now >= next() - 1.5 * period_;
  }
  /// True if a tick is due; this advances the schedule to the first grid point after `now` [s].
  [[nodiscard]] bool due(double now);
  /// Leaves out the ticks before `time` [s]; returns how many more than before. The grid stays.
  int skip_until(double time);
  /// Leaves out no ticks after `now` [s].
  void resume(double now);
  /// Time of the next tick [s].
  [[nodiscard]] double next() const { return start_ + period_ * ticks_; }
  /// How late a tick may be if nothing else wakes the thread earlier [s].
  [[nodiscard]] double slack() const { return period_ < kSlow ? 0.0 : kSlack; }

  static constexpr double kSlow = 0.5;    ///< [s] shortest period with some slack
  static constexpr double kSlack = 0.05;  ///< [s], so that slow ticks seldom wake a thread

 private:
  double period_;
  double start_;
  double ticks_ = 1.0;    // number of the next one; a product does not drift as a sum would
  double skipped_ = 0.0;  // how many later ones before it are left out
};

struct TimerState;

/// Calls its function at a fixed rate on the node's thread until it is destroyed. With a period of
/// 0.5 s or more, a call may come 0.05 s late if nothing else wakes the thread.
class TANDEM_EXPORT Timer {
 public:
  Timer() = default;
  /// Made by Node::create_timer().
  Timer(std::shared_ptr<NodeCore> node, std::shared_ptr<TimerState> state);
  ~Timer();
  Timer(Timer&&) noexcept = default;
  Timer& operator=(Timer&& other) noexcept;

  /// Says that its function has nothing to do before `time` [s] on the timer's clock, so that the
  /// node does not wake for the ticks before it. Returns how many ticks that leaves out; 0 on a
  /// LocalBus, which runs them all the same.
  int skip_until(double time);
  /// Takes skip_until() back: the next tick is not left out.
  void resume();

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<TimerState> state_;
};

}  // namespace tandem::runtime
