// SPDX-License-Identifier: Apache-2.0
// Models the imperfections of hands and input devices: turns the intended stick motion into the
// actual one.
#pragma once

#include <random>
#include <set>
#include <string>
#include <vector>

#include "tandem/config/params.hpp"

namespace tandem {

/// State of a joystick: forward and left in [−1, 1], and whether the dead-man is held. A person
/// means deflections beyond the dead zone; what HandModel returns are positions of the stick.
struct Hand {
  double linear = 0.0, angular = 0.0;  ///< [1]
  bool holds = true;                   ///< the dead-man is held
};

/// How the actual stick motion differs from the intended one. Frequencies, damping and the drift
/// have sources; amplitudes, thresholds and event rates are our choice, within what still lets a
/// person drive.
///
///   tremor           a sine on both axes. Essential tremor lies in 4–12 Hz (Bhatia et al. 2018,
///                    consensus statement of the task force on tremor), Parkinson's in 3–8 Hz.
///   over_correction  the turning hand is an underdamped spring-mass system, which overshoots each
///                    change by exp(−π ζ / √(1 − ζ²)), 37 % for ζ = 0.3 (1); 0.8 Hz is our choice
///   one_sided        unilateral neglect: turns toward the neglected side are weaker, and the
///                    path drifts to the other side, as in line bisection (Urbanski and Bartolomeo
///                    2008: patients with left neglect bisect right of the middle)
///   quantised        a four-way switch: full deflection along the larger axis
///   pulses           sip and puff: the four-way switch, pressed for part of each period (ours)
///   dropouts         the hand slips off the stick and the dead-man at random (ours)
struct HandParams {
  double tremor_frequency = 0.0;
  double tremor_amplitude = 0.2;
  double over_correction_damping = 0.3;
  std::string neglected_side = "any";
  double neglect = 0.6;
  double pulse_period = 0.8;
  double pulse_duration = 0.5;
  double deadzone = 0.05;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("tremor_frequency", tremor_frequency, Range{0.0, 20.0},
          "[Hz] tremor frequency; 0: drawn between 4 and 12 from the seed");
    field("tremor_amplitude", tremor_amplitude, Range{0.0, 1.0},
          "[1] tremor amplitude as a fraction of the stick's travel");
    field("over_correction_damping", over_correction_damping, Range{0.05, 1.0},
          "[1] damping ratio of the hand");
    field("neglected_side", neglected_side, OneOf{{"left", "right", "any"}},
          "side that is neglected; any: drawn from the seed");
    field("neglect", neglect, Range{0.0, 1.0}, "[1] fraction of a turn to that side that is lost");
    field("pulse_period", pulse_period, Range{0.1, 10.0},
          "[s] interval between the starts of two pulses");
    field("pulse_duration", pulse_duration, Range{0.05, 10.0}, "[s] duration of a pulse");
    field("deadzone", deadzone, Range{0.0, 0.9},
          "[1] dead zone of the stick, which the person knows: teleop's `deadzone`");
  }
};

/// Names of all modifiers, in the order in which they are applied.
[[nodiscard]] const std::vector<std::string>& all_modifiers();

/// Applies modifiers to the intended stick motion, given beyond the dead zone; returns positions of
/// the stick. Intention and neglect come before the dead zone, the hand's own motion after it.
/// Deterministic for a seed.
class HandModel {
 public:
  /// `rate`: samples per second [Hz]. Throws std::invalid_argument on parameters out of range and
  /// on an unknown modifier.
  HandModel(const HandParams& params, const std::set<std::string>& modifiers, double rate,
            unsigned seed);

  /// The actual sample at time t [s].
  [[nodiscard]] Hand apply(Hand meant, double t);

 private:
  [[nodiscard]] bool has(const char* modifier) const { return modifiers_.contains(modifier); }
  // A switch is on or off, and has no dead zone.
  [[nodiscard]] bool is_switch() const { return has("quantised") || has("pulses"); }
  void pass_dead_zone(Hand& hand) const;
  void tremble(Hand& hand, double t) const;
  void over_correct(Hand& hand);
  void neglect(Hand& hand) const;
  [[nodiscard]] Hand switched(const Hand& hand) const;
  void pulse(Hand& hand, double t);
  void drop_out(Hand& hand, double t);

  HandParams params_;
  std::set<std::string> modifiers_;
  double period_;  // [s] between two samples
  std::mt19937 random_;
  double tremor_frequency_ = 0.0, tremor_phase_ = 0.0;
  double neglected_ = 1.0;                // sign of the side: left 1, right −1
  double turn_ = 0.0, turn_speed_ = 0.0;  // state of the over-correcting hand
  long pulse_ = -1;                       // index of the current pulse period
  Hand pulsed_;
  double dropped_until_ = -1.0;
};

}  // namespace tandem
