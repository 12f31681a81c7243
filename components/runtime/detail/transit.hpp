// SPDX-License-Identifier: Apache-2.0
// In: when samples were sent and taken. Out: which of them come too late.
#pragma once

namespace tandem::runtime {

/// Tells of one writer's samples which were under way for longer than others by more than a
/// lifespan: in the queue of a process that stood still, in a network that was gone.
///
/// The two clocks need not agree. The least of (taken − sent) stands for their difference and the
/// shortest way; it is followed where it grows slowly (clocks drift) or for good (one was set).
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
