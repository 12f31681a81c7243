// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tandem/runtime/node.hpp"

namespace tandem::test {

inline constexpr double kTimeout = 20.0;      ///< [s] for what takes much less on a quiet machine
inline constexpr double kLongTimeout = 60.0;  ///< [s] for what starts programs on a slow machine

/// Spins the nodes in turn until `predicate` holds; false if it does not within `timeout` [s].
template <class Predicate, class... Nodes>
[[nodiscard]] bool spin_until(Predicate predicate, double timeout, Nodes&... nodes) {
  const double end = rt::steady_seconds() + timeout;
  while (!predicate()) {
    if (rt::steady_seconds() > end) return false;
    (nodes.spin_some(0.002), ...);
  }
  return true;
}

}  // namespace tandem::test
