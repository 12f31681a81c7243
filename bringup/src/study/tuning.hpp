// SPDX-License-Identifier: Apache-2.0
// Searches the parameter values with the lowest cost.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bringup/system/system.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {

/// A search variable: a parameter with bounds. Searched on a logarithmic scale if `low` > 0.
struct Knob {
  std::string component, name;
  double low = 0.0, high = 1.0;
  double start = 0.0;       ///< in [low, high]
  bool is_integer = false;  ///< values are rounded
};

/// Parses `component.parameter` or `component.parameter:low:high`. The default bounds are a fifth
/// of and five times the system's current value, within the parameter's range. Throws
/// std::invalid_argument if the component is unknown or not used by the system, the parameter is
/// not a number, the bounds are empty, outside the parameter's range or exclude the current value,
/// or there are none and the current value is not positive.
[[nodiscard]] Knob read_knob(const std::string& text, const System& system);

/// Parses each text with the first of the systems that uses the component; `systems` must not be
/// empty. Throws what read_knob throws, and std::invalid_argument if two texts name one parameter.
[[nodiscard]] std::vector<Knob> read_knobs(const std::vector<std::string>& texts,
                                           const std::vector<System>& systems);

/// Cost of a drive; lower is better. A drive as long as the reference time [s] costs at least 1:
///
///   time / reference + obedience_rms + 2 (share of commands that the filter changed)
///     + stuck_s / 10 s + 10 (collisions) + 10 (not reached)                               (1)
[[nodiscard]] double drive_cost(const DriveResult& drive, double reference_time);

struct Tuned {
  std::vector<double> values;  ///< one per search variable
  double cost = 0.0;           ///< the cost that the search minimizes
  double other_cost = 0.0;     ///< held-out cost
};

using Cost = std::function<double(const std::vector<double>&)>;

/// Subplex search (Rowan 1990, by NLopt) from the start values with at most `evaluations` calls of
/// `cost`. Values that lower `cost` are also rated by the held-out `other_cost`, and those with the
/// lowest held-out cost are returned (early stopping: Prechelt, Early Stopping – But When?, 1998).
/// The result is therefore never worse than the start by either cost. Deterministic.
[[nodiscard]] Tuned tune(const std::vector<Knob>& knobs, int evaluations, const Cost& cost,
                         const Cost& other_cost);

}  // namespace tandem
