// SPDX-License-Identifier: Apache-2.0
// Ramps the command up when another source takes over.
#pragma once

#include "tandem/model/se2.hpp"

namespace tandem {

/// Limits how fast the command in force grows after a change of authority. Forward speed and yaw
/// rate are limited separately; for each:
///
/// * The output has the sign of the chosen command and is never faster. A slower command is in
///   force immediately, and a command in the opposite direction stops the old motion immediately.
/// * A faster command is reached within `duration`, linearly if it is constant; the output equals
///   it once the same source has been in charge for that long.
/// * A further change during a ramp continues it at its pace or faster, so alternating sources do
///   not delay it.
///
/// Times are seconds on one monotonic clock.
class Handover {
 public:
  /// `duration`: longest ramp [s]; 0: none.
  explicit Handover(double duration) : duration_{duration} {}

  /// Returns the command in force at `now`. `changed`: the source in charge differs from the last
  /// call.
  [[nodiscard]] Twist2 follow(const Twist2& chosen, bool changed, double now);

  /// Call while the robot is stopped: the next command is then in force without a ramp.
  void stop() { v_ = w_ = {}; }
  /// Call after the clock jumped back: the next command is in force without a ramp, unless it
  /// starts one.
  void end_ramp() { v_.end = w_.end = kEnded; }

 private:
  static constexpr double kEnded = -1e300;  // [s] before any time

  // One component of the command; a ramp is running while time < end.
  struct Ramp {
    double value = 0.0;  // command in force
    double time = 0.0;   // of `value` [s]
    double end = 0.0;    // [s]
    double pace = 0.0;   // smallest growth per `duration`

    void start(double growth, double now, double duration);
    double follow(double target, bool changed, double now, double duration);
    double finish(double target, double now);
  };

  double duration_;
  Ramp v_, w_;
};

}  // namespace tandem
