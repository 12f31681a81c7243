// SPDX-License-Identifier: Apache-2.0
// Measures a base's dead time, motor lag and braking from its commands and its odometry, so that
// the parameters of a robot file can be taken from a recording of steps.
#pragma once

#include <optional>
#include <span>

#include "tandem/model/stamped.hpp"

namespace tandem {

/// How one axis of a base, forward speed [m/s] or turn rate [rad/s], follows its command.
///
/// The model is first order with dead time (Åström & Hägglund 1995, PID Controllers, §2.4) and
/// bounded rates,
///
///   ẏ(t) = clamp((u(t − d) − y(t)) / τ, −b, b),   b = a_up if |y| grows, else a_down,       (1)
///
/// with the command u, in force until the next, and the speed y of the odometry.
struct StepResponse {
  double delay = 0.0;     ///< d, from sending a command to the arrival of its first effect [s]
  double lag = 0.0;       ///< τ [s]
  double a_up = 0.0;      ///< [m/s²] or [rad/s²]; large if no bound shows
  double residual = 0.0;  ///< RMS error of (1), as a share of the RMS of y
  /// Least mean deceleration between 90 % and 10 % of the speed after a command of zero [m/s²] or
  /// [rad/s²]; 0: no stop was recorded.
  double braking = 0.0;
  int stops = 0;  ///< number of stops that `braking` is the least of
};

/// Fits (1) by least squares. `commands` with the time of sending and `measured` with the time of
/// arrival, both in order of time, on one clock. Nullopt if either has less than two values, or the
/// command does not change by at least a quarter of its largest magnitude.
[[nodiscard]] std::optional<StepResponse> step_response(std::span<const Stamped<double>> commands,
                                                        std::span<const Stamped<double>> measured);

}  // namespace tandem
