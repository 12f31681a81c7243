// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/hand.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tandem/model/dead_zone.hpp"

namespace tandem {
namespace {

constexpr double kTremorLow = 4.0, kTremorHigh = 12.0;  // [Hz]
constexpr double kOverCorrection = 0.8;     // [Hz] undamped frequency of the turning hand
constexpr double kDropoutsPerMinute = 6.0;  // on average
constexpr double kDropoutTime = 0.5;        // [s] on average
constexpr double kNeglectDrift = 0.1;       // [1] bias to the other side while driving
constexpr double kSwitchThreshold = 0.25;   // [1] deflection that presses the four-way switch
constexpr double kSubStep = 0.002;          // [s] integration step of the hand's spring and mass

}  // namespace

const std::vector<std::string>& all_modifiers() {
  static const std::vector<std::string> all{"one_sided", "over_correction", "tremor",
                                            "quantised", "pulses",          "dropouts"};
  return all;
}

HandModel::HandModel(const HandParams& params, const std::set<std::string>& modifiers, double rate,
                     unsigned seed)
    : params_{params}, modifiers_{modifiers}, period_{1.0 / rate}, random_{seed} {
  check(params_);
  for (const auto& modifier : modifiers_)
    if (std::find(all_modifiers().begin(), all_modifiers().end(), modifier) ==
        all_modifiers().end())
      throw std::invalid_argument("`" + modifier + "` is not a modifier of drivers");
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  tremor_frequency_ = kTremorLow + unit(random_) * (kTremorHigh - kTremorLow);
  if (params_.tremor_frequency > 0.0) tremor_frequency_ = params_.tremor_frequency;
  tremor_phase_ = 2.0 * std::numbers::pi * unit(random_);
  neglected_ = unit(random_) < 0.5 ? 1.0 : -1.0;
  if (params_.neglected_side != "any") neglected_ = params_.neglected_side == "left" ? 1.0 : -1.0;
}

Hand HandModel::apply(Hand meant, double t) {
  Hand hand = meant;
  if (!meant.holds) return {0.0, 0.0, false};
  if (has("one_sided")) neglect(hand);
  if (!is_switch()) pass_dead_zone(hand);
  if (has("over_correction")) over_correct(hand);
  if (has("tremor")) tremble(hand, t);
  if (has("quantised")) hand = switched(hand);
  if (has("pulses")) pulse(hand, t);
  if (has("dropouts")) drop_out(hand, t);
  return {std::clamp(hand.linear, -1.0, 1.0), std::clamp(hand.angular, -1.0, 1.0), hand.holds};
}

void HandModel::tremble(Hand& hand, double t) const {
  const double phase = 2.0 * std::numbers::pi * tremor_frequency_ * t + tremor_phase_;
  hand.linear += params_.tremor_amplitude * std::sin(phase);
  hand.angular += params_.tremor_amplitude * std::cos(phase);
}

// A person learns where the stick begins to act.
void HandModel::pass_dead_zone(Hand& hand) const {
  hand.linear = through_dead_zone(hand.linear, params_.deadzone);
  hand.angular = through_dead_zone(hand.angular, params_.deadzone);
}

// x″ = ω² (u − x) − 2 ζ ω x′, whose step response overshoots by (1).
void HandModel::over_correct(Hand& hand) {
  const double omega = 2.0 * std::numbers::pi * kOverCorrection;
  const int steps = std::max(1, static_cast<int>(std::ceil(period_ / kSubStep)));
  const double dt = period_ / steps;
  for (int i = 0; i < steps; ++i) {
    turn_speed_ += dt * (omega * omega * (hand.angular - turn_) -
                         2.0 * params_.over_correction_damping * omega * turn_speed_);
    turn_ += dt * turn_speed_;
  }
  hand.angular = turn_;
}

void HandModel::neglect(Hand& hand) const {
  if (hand.angular * neglected_ > 0.0) hand.angular *= 1.0 - params_.neglect;
  if (hand.linear != 0.0 || hand.angular != 0.0) hand.angular -= neglected_ * kNeglectDrift;
}

Hand HandModel::switched(const Hand& hand) const {
  const double linear = std::abs(hand.linear), angular = std::abs(hand.angular);
  if (std::max(linear, angular) <= kSwitchThreshold) return {0.0, 0.0, hand.holds};
  if (linear >= angular) return {std::copysign(1.0, hand.linear), 0.0, hand.holds};
  return {0.0, std::copysign(1.0, hand.angular), hand.holds};
}

void HandModel::pulse(Hand& hand, double t) {
  const auto index = static_cast<long>(std::floor(t / params_.pulse_period));
  if (index != pulse_) pulsed_ = switched(hand);
  pulse_ = index;
  const double age = t - static_cast<double>(index) * params_.pulse_period;
  hand.linear = age < params_.pulse_duration ? pulsed_.linear : 0.0;
  hand.angular = age < params_.pulse_duration ? pulsed_.angular : 0.0;
}

// Drop-outs start as a Poisson process and last an exponentially distributed time.
void HandModel::drop_out(Hand& hand, double t) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  if (t >= dropped_until_ && unit(random_) < period_ * kDropoutsPerMinute / 60.0)
    dropped_until_ = t - kDropoutTime * std::log(1.0 - unit(random_));
  if (t < dropped_until_) hand = {0.0, 0.0, false};
}

}  // namespace tandem
