// SPDX-License-Identifier: Apache-2.0
#include "tandem/metrics/step_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

namespace tandem {
namespace {

using Signal = std::span<const Stamped<double>>;

constexpr double kMaxDelay = 0.6;    // [s]
constexpr double kAtRest = 0.02;     // share of the largest command that counts as zero
constexpr double kFastEnough = 0.3;  // share of the largest speed from which a stop counts

double largest(Signal signal) {
  double most = 0.0;
  for (const auto& sample : signal) most = std::max(most, std::abs(sample.value));
  return most;
}

double span_of(Signal signal) {
  const auto [least, most] = std::minmax_element(
      signal.begin(), signal.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  return most->value - least->value;
}

struct Model {
  double delay, lag;    // [s]
  double a_up, a_down;  // [m/s²] or [rad/s²]
};

// The speed of the model, from one time to the next.
class Follower {
 public:
  Follower(const Model& model, double y, double t) : model_{model}, y_{y}, t_{t} {}

  void follow(double u, double until) {
    for (int pieces = 0; t_ < until && pieces < kMaxPieces; ++pieces) advance(u, until - t_);
    t_ = until;
  }
  [[nodiscard]] double y() const { return y_; }
  [[nodiscard]] double t() const { return t_; }

 private:
  static constexpr int kMaxPieces = 4;  // ramp and exponential, before and after y = 0

  // Up to where the rate's bound begins or ends to apply, `most` [s] at most.
  void advance(double u, double most) {
    const double gap = u - y_;
    const bool turns_round = u * y_ < 0.0;
    const double bound = turns_round || std::abs(u) < std::abs(y_) ? model_.a_down : model_.a_up;
    double dt = most;
    if (std::abs(gap) > bound * model_.lag * (1.0 + 1e-9)) {
      dt = std::min(dt, std::abs(gap) / bound - model_.lag);
      if (turns_round) dt = std::min(dt, std::abs(y_) / bound);
      y_ += std::copysign(bound * dt, gap);
    } else {
      if (turns_round) dt = std::min(dt, model_.lag * std::log(gap / u));
      y_ = u - gap * std::exp(-dt / model_.lag);
    }
    if (turns_round && dt < most && std::abs(y_) < 1e-9) y_ = 0.0;
    t_ += dt;
  }

  const Model& model_;
  double y_, t_;
};

// The error of the model at each measured value, as a function of d, log τ, log a_up and log
// a_down. The model starts at the first measured value.
struct Errors {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  Signal commands, measured;

  [[nodiscard]] static Eigen::Index inputs() { return 4; }
  [[nodiscard]] Eigen::Index values() const { return static_cast<Eigen::Index>(measured.size()); }

  int operator()(const Eigen::VectorXd& p, Eigen::VectorXd& errors) const {
    const Model model = model_at(p);
    Follower base{model, measured.front().value, measured.front().t};
    double u = 0.0;
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < values(); ++i) {
      const auto& sample = measured[static_cast<std::size_t>(i)];
      for (; next < commands.size() && commands[next].t + model.delay <= sample.t; ++next) {
        base.follow(u, std::max(base.t(), commands[next].t + model.delay));
        u = commands[next].value;
      }
      base.follow(u, sample.t);
      errors[i] = base.y() - sample.value;
    }
    return 0;
  }

  [[nodiscard]] static Model model_at(const Eigen::VectorXd& p) {
    const auto positive = [](double log) { return std::exp(std::clamp(log, -12.0, 12.0)); };
    return {std::clamp(p[0], 0.0, kMaxDelay), positive(p[1]), positive(p[2]), positive(p[3])};
  }
};

struct Fit {
  Model model;
  double error;  // sum of the squared errors
};

Fit improved(const Errors& errors, const Model& start) {
  Eigen::VectorXd p{
      {start.delay, std::log(start.lag), std::log(start.a_up), std::log(start.a_down)}};
  constexpr double kNoise = 1e-8;  // relative precision of the errors, for the differences' step
  Eigen::NumericalDiff<Errors> differentiable{errors, kNoise};
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Errors>> search{differentiable};
  search.parameters.maxfev = 400;
  search.minimize(p);
  return {Errors::model_at(p), search.fnorm * search.fnorm};
}

// The best of searches from several starts, because the error has local minima: in time, and where
// a bound of the rate looks like a lag.
Fit best_fit(Signal commands, Signal measured) {
  const Errors errors{commands, measured};
  const double speed = largest(commands);
  Fit best{{}, std::numeric_limits<double>::infinity()};
  for (const double delay : {0.01, 0.05, 0.1, 0.2, 0.4})
    for (const double lag : {0.03, 0.15})
      for (const double rate : {1.0, 30.0}) {  // full speed within a second; as good as unbounded
        const Fit fit = improved(errors, {delay, lag, speed * rate, speed * rate});
        if (fit.error < best.error) best = fit;
      }
  return best;
}

// Mean deceleration between 90 % and 10 % of the speed at `begin`, before `end` [s]; 0 if the speed
// does not fall that far, or was too low to tell.
double deceleration(Signal measured, double begin, double end, double least_speed) {
  double v0 = 0.0, from = 0.0;
  bool falls = false;
  for (const auto& sample : measured) {
    const double v = std::abs(sample.value);
    if (sample.t <= begin) {
      v0 = v;
    } else if (v0 < least_speed || sample.t > end) {
      return 0.0;
    } else if (!falls && v <= 0.9 * v0) {
      falls = true;
      from = sample.t;
    }
    if (falls && v <= 0.1 * v0) return sample.t > from ? 0.8 * v0 / (sample.t - from) : 0.0;
  }
  return 0.0;
}

void find_stops(Signal commands, Signal measured, StepResponse& response) {
  const double rest = kAtRest * largest(commands), fast = kFastEnough * largest(measured);
  for (std::size_t i = 1; i < commands.size(); ++i) {
    if (std::abs(commands[i].value) > rest || std::abs(commands[i - 1].value) <= rest) continue;
    std::size_t next = i + 1;
    while (next < commands.size() && std::abs(commands[next].value) <= rest) ++next;
    const double end = next < commands.size() ? commands[next].t : measured.back().t;
    const double found = deceleration(measured, commands[i].t, end, fast);
    if (found <= 0.0) continue;
    response.braking = response.stops == 0 ? found : std::min(response.braking, found);
    ++response.stops;
  }
}

}  // namespace

std::optional<StepResponse> step_response(Signal commands, Signal measured) {
  if (commands.size() < 2 || measured.size() < 2) return std::nullopt;
  if (!(span_of(commands) >= 0.25 * largest(commands)) || largest(commands) == 0.0)
    return std::nullopt;
  const Fit fit = best_fit(commands, measured);
  double power = 0.0;
  for (const auto& sample : measured.subspan(1)) power += sample.value * sample.value;
  StepResponse response{.delay = fit.model.delay, .lag = fit.model.lag, .a_up = fit.model.a_up};
  response.residual = power > 0.0 ? std::sqrt(fit.error / power) : 1.0;
  find_stops(commands, measured, response);
  return response;
}

}  // namespace tandem
