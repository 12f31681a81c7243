// SPDX-License-Identifier: Apache-2.0
// In: parameters that may vary and costs of their values. Out: the best values found.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bringup/system/system.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {

/// A parameter that may vary. Searched on a logarithmic scale where `low` > 0.
struct Knob {
  std::string component, name;
  double low = 0.0, high = 1.0;
  double start = 0.0;       ///< in [low, high]
  bool is_integer = false;  ///< values are rounded
};

/// Reads `component.parameter` or `component.parameter:low:high`; without bounds a fifth to five
/// times the value that the system has now, within the parameter's range. Throws
/// std::invalid_argument for an unknown component, one that the system does not use, a parameter
/// that is no number, empty bounds, or bounds that leave out the value that the system has now.
[[nodiscard]] Knob read_knob(const std::string& text, const System& system);

/// One each, of the first of the systems (at least one) that uses the component. Throws what
/// read_knob throws, and std::invalid_argument if two texts mean one parameter.
[[nodiscard]] std::vector<Knob> read_knobs(const std::vector<std::string>& texts,
                                           const std::vector<System>& systems);

/// What a drive is worth; lower is better, a drive as long as the reference costs 1 and more:
///
///   time / reference + obedience_rms + 2 (share of commands that the filter changed)
///     + stuck_s / 10 s + 10 (collisions) + 10 (not reached)                               (1)
[[nodiscard]] double drive_cost(const DriveResult& drive, double reference_time);

struct Tuned {
  std::vector<double> values;  ///< one per knob
  double cost = 0.0;           ///< of the search
  double other_cost = 0.0;     ///< of what the search does not see
};

using Cost = std::function<double(const std::vector<double>&)>;

/// Subplex search (Rowan 1990, by NLopt) from the knobs' starts with at most `evaluations` calls of
/// `cost`. Each value that lowers it is rated by `other_cost` too, and what costs least there is
/// returned (early stopping: Prechelt, Early Stopping – But When?, 1998); so it is never worse than
/// the starts by either. Deterministic.
[[nodiscard]] Tuned tune(const std::vector<Knob>& knobs, int evaluations, const Cost& cost,
                         const Cost& other_cost);

}  // namespace tandem
