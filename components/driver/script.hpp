// SPDX-License-Identifier: Apache-2.0
// Simulates a person with a task, who docks, turns, reverses, waits and pushes according to a
// script.
#pragma once

#include <deque>
#include <random>
#include <string>
#include <vector>

#include "tandem/driver/hand.hpp"
#include "tandem/driver/navigator.hpp"
#include "tandem/driver/script_phase.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Executes the phases of a script and then releases the dead-man. Deterministic for a seed.
///
/// The person sees the robot and its leader `reaction_delay` late, aims `preview` ahead on the
/// route and keeps a leader no farther ahead than that; at the end of a route the leader waits for
/// its robot. The hand's noise grows with the deflection (Harris and Wolpert 1998) and is zero with
/// the stick at rest. If the robot stands still for `patience` on a path or a turn, the person
/// pushes harder; after the same time again they back out and retry.
class Script {
 public:
  /// Uses rate, reaction_delay, preview, stick_noise and patience of the parameters.
  /// Throws what read_script throws.
  Script(const std::string& text, const NavigatorParams& params, const Footprint& outline,
         unsigned seed);

  /// Returns one joystick sample; call every 1 / rate seconds. `X_MB`: the robot; `X_MS`: what the
  /// stick steers, the robot itself or its leader.
  [[nodiscard]] Hand steer(const Pose2& X_MB, const Pose2& X_MS, double t);

  /// Whether the last phase is over.
  [[nodiscard]] bool arrived() const { return phase_ == phases_.size(); }

 private:
  struct Seen {
    double t = 0.0;
    Pose2 X_MB, X_MS;
    [[nodiscard]] bool leads() const { return !(X_MS == X_MB); }
  };

  void look(const Pose2& X_MB, const Pose2& X_MS, double t);
  void begin(double t);
  [[nodiscard]] bool is_done(double t);
  [[nodiscard]] bool is_there(const PathPhase& path);
  [[nodiscard]] bool is_there(const TurnPhase& turn) const;
  [[nodiscard]] Hand meant() const;
  [[nodiscard]] Hand meant(const PathPhase& path) const;
  [[nodiscard]] Hand meant(const TurnPhase& turn) const;
  [[nodiscard]] double pushed(const PathPhase& path) const;
  [[nodiscard]] Hand back_out() const;
  void lose_patience(double t);
  void be_patient(double t);
  [[nodiscard]] Hand with_noise(Hand hand);

  NavigatorParams params_;
  std::vector<ScriptPhase> phases_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  double noise_linear_ = 0.0, noise_angular_ = 0.0;
  std::deque<Seen> seen_;  // the front is what the person sees now, after the delay

  std::size_t phase_ = 0;
  bool started_ = false;
  double phase_start_ = 0.0;                        // [s]
  double progress_ = 0.0, steered_progress_ = 0.0;  // [m] of robot and leader along the path
  Stamped<Pose2> moved_;                            // where and when the robot last moved
  bool is_eager_ = false;                           // pushes harder
  double back_out_until_ = 0.0;                     // [s]
};

}  // namespace tandem
