// SPDX-License-Identifier: Apache-2.0
// Detects late samples from their send and receive times, without synchronized clocks.
#pragma once

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Detects samples of one writer whose transit exceeds its usual minimum by more than the lifespan,
/// for example because a process stalled or the network was down.
///
/// The clocks need not be synchronized. The minimum of (taken − sent) estimates the clock offset
/// plus the shortest delay; it follows slow growth (clock drift) and lasting jumps (a clock was
/// set).
class TANDEM_EXPORT_FOR_TESTS Transit {
 public:
  static constexpr double kDrift = 1e-3;   ///< maximum clock drift [s/s]
  static constexpr double kForGood = 1.0;  ///< [s] until a lasting delay is the new minimum

  /// Whether to drop the sample. All times in [s]: `sent` by the writer's clock, `taken` by ours.
  /// An infinite lifespan drops none.
  [[nodiscard]] bool is_late(double sent, double taken, double lifespan);

 private:
  bool known_ = false;
  double least_ = 0.0;       // minimum of taken − sent [s]
  double last_ = 0.0;        // when the last sample was taken [s]
  double late_since_ = 0.0;  // when the first late sample was taken [s]
  bool late_ = false;
};

}  // namespace tandem::runtime
