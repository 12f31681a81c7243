// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

namespace tandem::runtime {

class NodeCore;

/// Beats of a fixed period. Late beats are skipped, never replayed.
class Beat {
 public:
  /// The first beat is one period after `start`. Throws std::invalid_argument unless period > 0.
  Beat(double start, double period);

  /// True if a beat is due; the next one is then the first of the grid that lies after `now`.
  [[nodiscard]] bool due(double now);
  [[nodiscard]] double next() const { return next_; }

 private:
  double period_;
  double next_;
};

struct TimerState;

/// Calls its function at a fixed rate on the node's thread until it is destroyed.
class Timer {
 public:
  Timer() = default;
  Timer(std::shared_ptr<NodeCore> node, std::shared_ptr<TimerState> state);
  ~Timer();
  Timer(Timer&&) noexcept = default;
  Timer& operator=(Timer&& other) noexcept;

 private:
  void close();

  std::shared_ptr<NodeCore> node_;
  std::shared_ptr<TimerState> state_;
};

}  // namespace tandem::runtime
