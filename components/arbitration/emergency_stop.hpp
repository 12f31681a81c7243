// SPDX-License-Identifier: Apache-2.0
// The latch of the emergency stop, and what must happen after its release before the robot moves.
#pragma once

#include <optional>

#include "tandem/model/se2.hpp"

namespace tandem {

/// Latches until it is released. The release is no command to start (ISO 13850, 4.1.4): the person
/// must let go of the stick and then steer, or choose autonomy anew.
///
/// Letting go must be seen: a command at rest arrived, and for `rest_time` after it none that
/// steers. What was seen before the release counts too. Silence alone does not count, because a
/// stick that is held through a lost link is silent as well; but after a command at rest it does,
/// because most devices say zero once when they are let go, and nothing more. A device must
/// therefore never say zero merely because it does not know where its stick is.
///
/// Times are seconds on one monotonic clock.
class EmergencyStop {
 public:
  /// What is still missing before the robot may move.
  enum class Awaits { kNothing, kRelease, kLettingGo, kSteering };

  /// `rest_time`: how long the person must not steer [s].
  explicit EmergencyStop(double rest_time) : rest_time_{rest_time} {}

  void on_signal(bool pressed);
  /// Only after the last signal was `false`. Whether the stop is released now.
  [[nodiscard]] bool release();
  [[nodiscard]] bool latched() const { return latched_; }

  /// A person's command, finite.
  void on_user(const Twist2& twist, double t);
  /// `autonomous`: autonomy was chosen since the stop was pressed. It then needs no steering, and
  /// no letting go either if no person has ever been heard.
  [[nodiscard]] Awaits awaits(double now, bool autonomous);
  /// The clock was set back to `now`: a rest that is under way begins there.
  void set_clock_back(double now);

 private:
  [[nodiscard]] bool has_let_go(double now) const {
    return rest_since_ && now - *rest_since_ >= rest_time_;
  }

  double rest_time_;
  bool pressed_ = false, latched_ = false;
  bool must_restart_ = false;
  bool heard_person_ = false;
  std::optional<double> rest_since_;  // the first command at rest since the last that steered
};

}  // namespace tandem
