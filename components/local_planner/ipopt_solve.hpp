// SPDX-License-Identifier: Apache-2.0
// In: an optimal control problem and a guess. Out: where Ipopt ended, primal and dual.
#pragma once

#include "local_planner/ocp.hpp"
#include "local_planner/solve.hpp"

namespace tandem {

/// Local minimum of `ocp` from `guess`, to an optimality error of 1e-4 at a barrier of 1e-4.
///
/// One solve at a time per process: MUMPS under Ipopt 3.11.9 is not thread safe, neither while
/// solving nor while it is built or destroyed. Others wait, at most until their deadline.
[[nodiscard]] Solution ipopt_solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits);

}  // namespace tandem
