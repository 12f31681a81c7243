// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/hand.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tandem/model/dead_zone.hpp"

namespace tandem {
namespace {

constexpr double kRate = 100.0;

std::vector<Hand> played(HandModel& model, const Hand& meant, double duration) {
  std::vector<Hand> hands;
  for (int i = 0; i < static_cast<int>(duration * kRate); ++i)
    hands.push_back(model.apply(meant, i / kRate));
  return hands;
}

// A hand at a stick without a dead zone.
HandModel model(const char* modifier, HandParams params = {}, unsigned seed = 1) {
  params.deadzone = 0.0;
  return HandModel{params, {modifier}, kRate, seed};
}

TEST(HandModel, ChangesNothingWithoutAModifier) {
  HandModel plain{{.deadzone = 0.0}, {}, kRate, 1};
  for (const Hand& hand : played(plain, {0.7, -0.3}, 1.0)) {
    EXPECT_EQ(hand.linear, 0.7);
    EXPECT_EQ(hand.angular, -0.3);
    EXPECT_TRUE(hand.holds);
  }
}

// Deflection that counts of a stick that is meant to be at (0.5, turn).
Hand counts(const std::set<std::string>& modifiers, double turn) {
  const HandParams params{.neglected_side = "left", .deadzone = 0.2};
  HandModel hand{params, modifiers, kRate, 1};
  const Hand at = hand.apply({0.5, turn}, 0.0);
  return {beyond_dead_zone(at.linear, 0.2), beyond_dead_zone(at.angular, 0.2), at.holds};
}

TEST(HandModel, PushesThroughTheDeadZoneOfTheStick) {
  for (const double turn : {-1.0, -0.3, -0.01, 0.0, 0.01, 0.3, 1.0}) {
    const Hand hand = counts({}, turn);
    EXPECT_NEAR(hand.linear, 0.5, 1e-12);
    EXPECT_NEAR(hand.angular, turn, 1e-12);
  }
  HandModel rests{{.deadzone = 0.2}, {}, kRate, 1};
  EXPECT_EQ(rests.apply({0.0, 0.0}, 0.0).angular, 0.0);
}

TEST(HandModel, NeglectsAShareOfTheTurnNotOfTheSticksTravel) {
  EXPECT_NEAR(counts({"one_sided"}, 1.0).angular, 1.0 * 0.4 - 0.1, 1e-12);
  EXPECT_NEAR(counts({"one_sided"}, 0.0).angular, -0.1, 1e-12);
}

TEST(HandModel, TremblesWithinTheDeadZoneOfAStickAtRest) {
  HandModel hand{{.tremor_amplitude = 0.15, .deadzone = 0.2}, {"tremor"}, kRate, 1};
  for (const Hand& at : played(hand, {0.0, 0.0}, 1.0))
    EXPECT_EQ(beyond_dead_zone(at.linear, 0.2), 0.0);
}

TEST(HandModel, PressesASwitchAsWithoutADeadZone) {
  EXPECT_EQ(counts({"quantised"}, 0.2).linear, 1.0);
  HandModel hand{{.deadzone = 0.2}, {"quantised"}, kRate, 1};
  EXPECT_EQ(hand.apply({0.2, 0.0}, 0.0).linear, 0.0);
}

TEST(HandModel, LetsGoWhenItsOwnerDoes) {
  for (const auto& modifier : all_modifiers()) {
    HandModel it = model(modifier.c_str());
    const Hand hand = it.apply({1.0, 1.0, false}, 0.0);
    EXPECT_FALSE(hand.holds) << modifier;
    EXPECT_EQ(hand.linear, 0.0) << modifier;
  }
}

// Checks the spectrum: all power lies at one frequency within the band given in the literature.
TEST(HandModel, TremorIsASineOfFourToTwelveHertz) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    HandModel it = model("tremor", {}, seed);
    const auto hands = played(it, {0.0, 0.0}, 10.0);
    double in_band = 0.0, all = 0.0;
    for (double f = 0.5; f < 20.0; f += 0.1) {
      double re = 0.0, im = 0.0;
      for (std::size_t i = 0; i < hands.size(); ++i) {
        const double phase = 2.0 * std::numbers::pi * f * static_cast<double>(i) / kRate;
        re += hands[i].linear * std::cos(phase);
        im += hands[i].linear * std::sin(phase);
      }
      all += re * re + im * im;
      if (f > 3.8 && f < 12.2) in_band += re * re + im * im;
    }
    EXPECT_GT(in_band, 0.98 * all) << seed;
    double largest = 0.0;
    for (const Hand& hand : hands) largest = std::max(largest, std::abs(hand.angular));
    EXPECT_NEAR(largest, HandParams{}.tremor_amplitude, 0.01);
  }
}

TEST(HandModel, OverCorrectionOvershootsAsItsDampingSays) {
  HandModel it = model("over_correction");
  double peak = 0.0;
  const auto hands = played(it, {0.5, 0.5}, 10.0);
  for (const Hand& hand : hands) peak = std::max(peak, hand.angular);
  const double zeta = HandParams{}.over_correction_damping;
  const double overshoot = std::exp(-std::numbers::pi * zeta / std::sqrt(1.0 - zeta * zeta));
  EXPECT_NEAR(peak, 0.5 * (1.0 + overshoot), 0.01);
  EXPECT_NEAR(hands.back().angular, 0.5, 0.01);
  EXPECT_EQ(hands.back().linear, 0.5);
}

TEST(HandModel, OneSidedTurnsLessToTheNeglectedSideAndDriftsToTheOther) {
  HandModel it = model("one_sided", {.neglected_side = "left"});
  EXPECT_NEAR(it.apply({0.0, 0.5}, 0.0).angular, 0.5 * 0.4 - 0.1, 1e-12);
  EXPECT_NEAR(it.apply({0.0, -0.5}, 0.0).angular, -0.6, 1e-12);
  EXPECT_NEAR(it.apply({0.5, 0.0}, 0.0).angular, -0.1, 1e-12);
  EXPECT_EQ(it.apply({0.0, 0.0}, 0.0).angular, 0.0);
  int left = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    HandModel any = model("one_sided", {}, seed);
    left += any.apply({0.5, 0.0}, 0.0).angular < 0.0 ? 1 : 0;
  }
  EXPECT_GT(left, 60);
  EXPECT_LT(left, 140);
}

TEST(HandModel, QuantisedKnowsFourDirectionsAndRest) {
  HandModel it = model("quantised");
  for (double linear = -1.0; linear <= 1.0; linear += 0.1)
    for (double angular = -1.0; angular <= 1.0; angular += 0.1) {
      const Hand hand = it.apply({linear, angular}, 0.0);
      const double pressed = std::abs(hand.linear) + std::abs(hand.angular);
      const bool wants = std::max(std::abs(linear), std::abs(angular)) > 0.25;
      EXPECT_EQ(pressed, wants ? 1.0 : 0.0) << linear << " " << angular;
    }
  EXPECT_EQ(it.apply({-0.6, 0.4}, 0.0).linear, -1.0);
  EXPECT_EQ(it.apply({0.4, -0.6}, 0.0).angular, -1.0);
}

TEST(HandModel, PulsesPressForAPartOfEachPeriod) {
  HandModel it = model("pulses", {.pulse_period = 1.0, .pulse_duration = 0.3});
  int on = 0, edges = 0;
  double before = 0.0;
  for (const Hand& hand : played(it, {0.8, 0.1}, 10.0)) {
    EXPECT_TRUE(hand.linear == 0.0 || hand.linear == 1.0);
    EXPECT_EQ(hand.angular, 0.0);
    on += hand.linear > 0.0 ? 1 : 0;
    edges += hand.linear > before ? 1 : 0;
    before = hand.linear;
  }
  EXPECT_EQ(edges, 10);
  EXPECT_NEAR(on, 300, 10);
}

TEST(HandModel, DropsOutAsOftenAndAsLongAsSaid) {
  HandModel it = model("dropouts");
  int dropped = 0, times = 0;
  bool held = true;
  for (const Hand& hand : played(it, {1.0, 0.2}, 6000.0)) {
    if (!hand.holds) {
      EXPECT_EQ(hand.linear, 0.0);
      ++dropped;
      times += held ? 1 : 0;
    }
    held = hand.holds;
  }
  EXPECT_NEAR(times, 600, 100);  // four standard deviations of the Poisson process
  EXPECT_NEAR(dropped / kRate, 300.0, 60.0);
}

TEST(HandModel, RefusesWhatItDoesNotKnow) {
  EXPECT_THROW(model("hiccup"), std::invalid_argument);
  EXPECT_THROW(model("tremor", {.tremor_amplitude = 2.0}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
