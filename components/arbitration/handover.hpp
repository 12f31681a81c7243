// SPDX-License-Identifier: Apache-2.0
// Ramps the command up when another source takes over.
#pragma once

#include "tandem/model/se2.hpp"

namespace tandem {

/// Limits how fast the command in force grows after a change of authority. Forward speed and yaw
/// rate are limited separately, and for both holds:
///
/// * The output has the sign of the chosen command and is never faster. A slower command is in
///   force at once, and one of the other direction stops the old motion at once.
/// * A faster command is reached within `duration`, linearly if it is constant; exactly so once the
///   same source has been in charge for that long.
/// * A ramp that a further change finds running continues at its pace or faster: sources that
///   alternate do not hold it up.
///
/// Times are seconds on one monotonic clock; a clock that is set back ends the ramp.
class Handover {
 public:
  /// `duration`: longest ramp [s]; 0: none.
  explicit Handover(double duration) : duration_{duration} {}

  /// The command in force at `now`. `changed`: another source is in charge than at the last call.
  [[nodiscard]] Twist2 follow(const Twist2& chosen, bool changed, double now);

  /// The robot stands: the next command is in force at once, as nothing was handed over.
  void stop() { v_ = w_ = {}; }

 private:
  // One component of the command; a ramp is running while time < end.
  struct Ramp {
    double value = 0.0;  // in force
    double time = 0.0;   // of `value` [s]
    double end = 0.0;    // [s]
    double pace = 0.0;   // least growth per duration

    void start(double growth, double now, double duration);
    double follow(double target, bool changed, double now, double duration);
    double finish(double target, double now);
  };

  double duration_;
  Ramp v_, w_;
};

}  // namespace tandem
