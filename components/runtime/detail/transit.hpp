// SPDX-License-Identifier: Apache-2.0
// Detects late samples from their send and receive times, without synchronized clocks.
#pragma once

namespace tandem::runtime {

/// Detects samples of one writer whose transit took longer than that of others by more than the
/// lifespan, because a process stalled or the network was down.
///
/// The clocks need not be synchronized. The minimum of (taken − sent) estimates the clock offset
/// plus the shortest delay; it follows slow growth (clock drift) and lasting jumps (a clock was
/// set).
class Transit {
 public:
  static constexpr double kDrift = 1e-3;   ///< [s/s] that the clocks may drift apart
  static constexpr double kForGood = 1.0;  ///< [s] after which later samples are not late any more

  /// Whether the sample is to be dropped. Times in seconds, `sent` by the writer's clock and
  /// `taken` by ours; a lifespan of infinity: never.
  [[nodiscard]] bool is_late(double sent, double taken, double lifespan);

 private:
  bool known_ = false;
  double least_ = 0.0;       // [s]
  double last_ = 0.0;        // [s] taken
  double late_since_ = 0.0;  // [s] taken
  bool late_ = false;
};

}  // namespace tandem::runtime
