// SPDX-License-Identifier: Apache-2.0
// Latches the emergency stop and decides when the robot may move again after its release.
#pragma once

#include <optional>

#include "tandem/model/se2.hpp"

namespace tandem {

/// Latches until released. The release is not a command to start (ISO 13850, 4.1.4): the person
/// must let go of the stick and then steer, or choose autonomy again.
///
/// Letting go must be observed: a command at rest arrived, and none that steers for `rest_time`
/// after it. A rest that began before the release counts too. Silence alone does not count, because
/// a stick held through a lost link is silent too. Silence after a command at rest counts, because
/// most devices send a single zero when they are let go. A device must therefore never send zero
/// merely because it does not know where its stick is.
///
/// Times are seconds on one monotonic clock.
class EmergencyStop {
 public:
  /// What is still required before the robot may move.
  enum class Awaits { kNothing, kRelease, kLettingGo, kSteering };

  /// `rest_time`: time without steering that counts as letting go [s].
  explicit EmergencyStop(double rest_time) : rest_time_{rest_time} {}

  /// Takes a signal of /e_stop; `true` latches the stop.
  void on_signal(bool pressed);
  /// Releases the latch if the last signal was `false`. Returns whether the stop is released now.
  [[nodiscard]] bool release();
  /// Whether the robot must stand.
  [[nodiscard]] bool latched() const { return latched_; }
  /// Whether a person has ever sent a command.
  [[nodiscard]] bool received_user() const { return received_user_; }

  /// Takes the person's command, which must be finite.
  void on_user(const Twist2& twist, double t);
  /// `autonomous`: autonomy was chosen after the stop was pressed. Then no steering is required,
  /// and no letting go either if no person has ever sent a command.
  [[nodiscard]] Awaits awaits(double now, bool autonomous);
  /// Call after the clock jumped back to `now`: a rest in progress restarts there.
  void on_time_jump(double now);

 private:
  [[nodiscard]] bool has_let_go(double now) const {
    return rest_since_ && now - *rest_since_ >= rest_time_;
  }

  double rest_time_;
  bool pressed_ = false, latched_ = false;
  bool must_restart_ = false;
  bool received_user_ = false;
  std::optional<double> rest_since_;  // first command at rest since the last steering one
};

}  // namespace tandem
