// SPDX-License-Identifier: Apache-2.0
#include "tandem/metrics/smoothness.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>

#include <unsupported/Eigen/FFT>

namespace tandem {
namespace {

constexpr double kLeastMagnitude = 0.05;  // of the largest
constexpr unsigned kPadding = 4;          // powers of two

// Magnitudes of the spectrum from 0 to the cut-off, half the sampling rate.
std::vector<double> spectrum(std::span<const double> speed) {
  std::vector<double> padded(std::bit_ceil(speed.size()) << kPadding);
  std::copy(speed.begin(), speed.end(), padded.begin());
  std::vector<std::complex<double>> bins;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(bins, padded);
  std::vector<double> magnitudes;
  for (const auto& bin : bins) magnitudes.push_back(std::abs(bin));
  return magnitudes;
}

}  // namespace

void SpeedProfile::add(double t, double value) {
  if (!started_) {
    started_ = true;
    start_ = t_ = t;
    value_ = value;
  }
  while (t > t_) {
    const double end = start_ + kWindow * static_cast<double>(means_.size() + 1);
    if (t < end) break;
    const double at_end = value_ + (value - value_) * (end - t_) / (t - t_);
    means_.push_back((area_ + 0.5 * (end - t_) * (value_ + at_end)) / kWindow);
    area_ = 0.0;
    t_ = end;
    value_ = at_end;
  }
  area_ += 0.5 * (t - t_) * (value_ + value);
  t_ = t;
  value_ = value;
}

std::optional<double> rms_of_second_difference(std::span<const double> speed) {
  if (speed.size() < 3) return std::nullopt;
  double sum = 0.0;
  for (std::size_t k = 1; k + 1 < speed.size(); ++k) {
    const double second = (speed[k + 1] - 2.0 * speed[k] + speed[k - 1]) /
                          (SpeedProfile::kWindow * SpeedProfile::kWindow);
    sum += second * second;
  }
  return std::sqrt(sum / static_cast<double>(speed.size() - 2));
}

std::optional<double> spectral_arc_length(std::span<const double> speed) {
  if (speed.size() < 2) return std::nullopt;
  std::vector<double> magnitudes = spectrum(speed);
  const double largest = *std::max_element(magnitudes.begin(), magnitudes.end());
  if (!(largest > 0.0)) return std::nullopt;
  for (double& magnitude : magnitudes) magnitude /= largest;
  const auto counts = [](double magnitude) { return magnitude >= kLeastMagnitude; };
  const auto first = std::find_if(magnitudes.begin(), magnitudes.end(), counts);
  const auto last = std::find_if(magnitudes.rbegin(), magnitudes.rend(), counts).base() - 1;
  const double step = 1.0 / static_cast<double>(std::max<std::ptrdiff_t>(1, last - first));
  double length = 0.0;
  for (auto m = first; m != last; ++m) length += std::hypot(step, *(m + 1) - *m);
  return -length;
}

}  // namespace tandem
