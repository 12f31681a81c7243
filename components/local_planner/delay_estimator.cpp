// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/delay_estimator.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr double kWindow = 4.0;        // [s] of measurements that are matched
constexpr double kLongest = 1.0;       // [s] longest delay tried
constexpr double kGrid = 0.01;         // [s] between delays tried, then refined
constexpr double kBetweenLooks = 0.5;  // [s] between estimates
constexpr double kSmoothing = 0.3;     // weight of a new estimate
constexpr double kExcited = 0.003;     // least variance of the measured twist, in shares of maximum
constexpr double kUnexplained = 0.15;  // largest residual, as a share of the grid's worst
constexpr std::size_t kMaxSamples = 4000;

}  // namespace

void DelayEstimator::forget() {
  sent_.clear();
  measured_.clear();
  next_look_ = kAtOnce;
}

void DelayEstimator::on_command(const Twist2& twist, double t) {
  if (!is_finite(twist) || !std::isfinite(t) || (!sent_.empty() && t < sent_.back().t)) return;
  sent_.push_back({twist, t});
  // The last command before the window is still in force at its beginning.
  while (sent_.size() > kMaxSamples ||
         (sent_.size() > 1 && sent_[1].t < t - kWindow - 2.0 * kLongest))
    sent_.pop_front();
}

void DelayEstimator::on_measurement(const Twist2& twist, double t) {
  if (!is_finite(twist) || !std::isfinite(t) || (!measured_.empty() && t <= measured_.back().t))
    return;
  measured_.push_back({twist, t});
  while (measured_.size() > kMaxSamples || measured_.front().t < t - kWindow) measured_.pop_front();
  if (t < next_look_) return;
  next_look_ = t + kBetweenLooks;
  const bool knows_enough = !sent_.empty() && sent_.front().t <= measured_.front().t - kLongest &&
                            measured_.front().t <= t - 0.5 * kWindow;
  if (!knows_enough || !is_excited()) return;
  if (const auto best = best_delay())
    delay_ = delay_ ? *delay_ + kSmoothing * (*best - *delay_) : *best;
}

bool DelayEstimator::is_excited() const {
  double v = 0.0, w = 0.0, vv = 0.0, ww = 0.0, n = 0.0;
  for (const auto& sample : measured_) {
    const double x = sample.value.v / v_max_, y = sample.value.w / w_max_;
    v += x, w += y, vv += x * x, ww += y * y, n += 1.0;
  }
  return (vv + ww - (v * v + w * w) / n) / n > kExcited;
}

// The mean of (1). A merge of both sequences, hence linear in their total length.
double DelayEstimator::residual(double delay) const {
  double sum = 0.0;
  std::size_t i = 0;
  for (const auto& sample : measured_) {
    while (i + 1 < sent_.size() && sent_[i + 1].t <= sample.t - delay) ++i;
    const double v = (sample.value.v - sent_[i].value.v) / v_max_;
    const double w = (sample.value.w - sent_[i].value.w) / w_max_;
    sum += v * v + w * w;
  }
  return sum / static_cast<double>(measured_.size());
}

// The best delay of a grid, refined by the parabola through its neighbours.
std::optional<double> DelayEstimator::best_delay() const {
  double best = 0.0, least = residual(0.0), most = least;
  for (double delay = kGrid; delay < kLongest + 0.5 * kGrid; delay += kGrid) {
    const double error = residual(delay);
    if (error < least) least = error, best = delay;
    most = std::max(most, error);
  }
  if (least > kUnexplained * most) return std::nullopt;
  if (best < kGrid || best > kLongest - kGrid) return best;
  const double before = residual(best - kGrid), after = residual(best + kGrid);
  const double curvature = before - 2.0 * least + after;
  return curvature > 0.0 ? best + 0.5 * kGrid * (before - after) / curvature : best;
}

}  // namespace tandem
