// SPDX-License-Identifier: Apache-2.0
#include "tandem/metrics/smoothness.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <random>

namespace tandem {
namespace {

std::vector<double> profile(double tick, const std::function<double(double)>& speed,
                            double seconds = 2.0) {
  SpeedProfile profile;
  for (long n = 0; n <= std::lround(seconds / tick); ++n) {
    const double t = 7.0 + tick * static_cast<double>(n);
    profile.add(t, speed(t - 7.0));
  }
  return profile.means();
}

double bump(double t) { return t < 0.0 || t > 1.0 ? 0.0 : 30.0 * t * t * (1.0 - t) * (1.0 - t); }

TEST(SpeedProfile, OfARampIsTheMiddleOfEachWindow) {
  const auto means = profile(
      0.01, [](double t) { return 3.0 * t; }, 1.005);
  ASSERT_EQ(means.size(), 10u);
  for (std::size_t k = 0; k < means.size(); ++k)
    EXPECT_NEAR(means[k], 3.0 * (0.1 * static_cast<double>(k) + 0.05), 1e-12);
}

TEST(SpeedProfile, IsTheSameAtWhateverTimesARampIsSeen) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> step{0.0, 0.25};
  SpeedProfile often, seldom;
  for (double t = 0.0; t < 3.0; t += 0.003) often.add(t, 2.0 * t);
  for (double t = 0.0; t < 3.0; t += step(random)) seldom.add(t, 2.0 * t);
  const std::size_t n = std::min(often.means().size(), seldom.means().size());
  ASSERT_GT(n, 20u);
  for (std::size_t k = 0; k < n; ++k) EXPECT_NEAR(often.means()[k], seldom.means()[k], 1e-9);
}

TEST(Jerk, OfASpeedQuadraticInTimeIsItsSecondDerivative) {
  const auto means = profile(0.001, [](double t) { return 0.3 + t - 1.7 * t * t; });
  EXPECT_NEAR(rms_of_second_difference(means).value(), 3.4, 1e-3);
  EXPECT_NEAR(rms_of_second_difference(profile(0.01, [](double t) { return t; })).value(), 0.0,
              1e-9);
}

TEST(Jerk, OfTwoWindowsIsUndefined) {
  EXPECT_FALSE(rms_of_second_difference(std::vector{1.0, 2.0}).has_value());
}

TEST(SpectralArcLength, OfAnImpulseIsMinusOne) {  // its spectrum is flat: nothing but the width
  EXPECT_NEAR(spectral_arc_length(std::vector{0.0, 5.0, 0.0, 0.0}).value(), -1.0, 1e-12);
}

TEST(SpectralArcLength, DoesNotChangeWithTheSizeOfTheSpeed) {
  auto speed = profile(0.01, bump);
  const double length = spectral_arc_length(speed).value();
  for (double& s : speed) s *= 17.0;
  EXPECT_NEAR(spectral_arc_length(speed).value(), length, 1e-9);
}

TEST(SpectralArcLength, OfTwoPushesIsLessSmoothThanOfOne) {
  const double one = spectral_arc_length(profile(0.01, bump)).value();
  const double two =
      spectral_arc_length(profile(0.01, [](double t) { return bump(t) + bump(t - 1.0); })).value();
  EXPECT_LT(two, one - 0.1);
  EXPECT_LT(one, -1.0);
}

// The definition, with the transform written out.
double by_definition(const std::vector<double>& speed) {
  std::size_t padded = 16;
  while (padded < 16 * speed.size()) padded *= 2;
  std::vector<double> magnitude;
  for (std::size_t k = 0; k <= padded / 2; ++k) {
    std::complex<double> bin;
    for (std::size_t n = 0; n < speed.size(); ++n)
      bin += speed[n] * std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k * n) /
                                            static_cast<double>(padded));
    magnitude.push_back(std::abs(bin));
  }
  const double largest = *std::max_element(magnitude.begin(), magnitude.end());
  std::size_t last = 0;
  for (std::size_t k = 0; k < magnitude.size(); ++k)
    if (magnitude[k] >= 0.05 * largest) last = k;
  double length = 0.0;
  for (std::size_t k = 0; k < last; ++k)
    length +=
        std::hypot(1.0 / static_cast<double>(last), (magnitude[k + 1] - magnitude[k]) / largest);
  return -length;
}

TEST(SpectralArcLength, IsWhatTheDefinitionSays) {
  std::mt19937 random{3};
  std::uniform_real_distribution<double> speed{0.0, 1.0};
  for (const std::size_t size : {2u, 5u, 16u, 31u, 100u}) {
    std::vector<double> speeds(size);
    for (double& s : speeds) s = speed(random);
    EXPECT_NEAR(spectral_arc_length(speeds).value(), by_definition(speeds), 1e-9) << size;
  }
}

TEST(SpectralArcLength, OfAStandingRobotIsUndefined) {
  EXPECT_FALSE(spectral_arc_length(std::vector<double>(20, 0.0)).has_value());
  EXPECT_FALSE(spectral_arc_length(std::vector<double>{}).has_value());
}

}  // namespace
}  // namespace tandem
