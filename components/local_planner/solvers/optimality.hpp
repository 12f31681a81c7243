// SPDX-License-Identifier: Apache-2.0
// Measures how far a primal-dual point is from optimal, from the problem's sparse form alone.
#pragma once

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// Final barrier parameter μ of both solvers, and their tolerance. A multiplier and its distance
/// from the bound have the product μ at the solution.
inline constexpr double kFinalBarrier = 1e-4, kTolerance = 1e-4;

/// Residuals of the first-order optimality conditions at kFinalBarrier, as Ipopt measures them
/// (Wächter and Biegler 2006, (5) and (6)).
struct OptimalityError {
  double dual = 0.0;             ///< largest component of the Lagrangian's gradient
  double primal = 0.0;           ///< largest violation of a row or bound [m], [rad] or [m/s]
  double complementarity = 0.0;  ///< largest |distance · multiplier − μ|
  double scale = 1.0;  ///< of the multipliers; dual and complementarity are not yet divided
};

/// `point` has as many multipliers as `ocp` has rows and bounds. Allocates. Thread-safe.
[[nodiscard]] OptimalityError optimality_error(const Ocp& ocp, const Iterate& point);

/// Whether Ipopt, with the options of ipopt_solve(), accepts the point without an iteration.
[[nodiscard]] bool is_optimal(const OptimalityError& error);

}  // namespace tandem
