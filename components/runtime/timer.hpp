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

  /// True if a tick is due; this advances the schedule to the first grid point after `now` [s].
  [[nodiscard]] bool due(double now);
  /// Leaves out the ticks before `time` [s]. The grid stays.
  void skip_until(double time);
  /// Time of the next tick [s].
  [[nodiscard]] double next() const { return start_ + period_ * ticks_; }

 private:
  double period_;
  double start_;
  double ticks_ = 1.0;    // number of the next one; a product does not drift as a sum would
  double skipped_ = 0.0;  // how many later ones before it are left out
};

struct TimerState;

/// Calls its function at a fixed rate on the node's thread until it is destroyed.
class TANDEM_EXPORT Timer {
 public:
  Timer() = default;
  /// Made by Node::create_timer().
  Timer(std::shared_ptr<NodeCore> node, std::shared_ptr<TimerState> state);
  ~Timer();
  Timer(Timer&&) noexcept = default;
  Timer& operator=(Timer&& other) noexcept;

  /// Says that its function has nothing to do before `time` [s] on the timer's clock, so that the
  /// node does not wake for the ticks before it. A LocalBus runs them all the same.
  void skip_until(double time);

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<TimerState> state_;
};

}  // namespace tandem::runtime
