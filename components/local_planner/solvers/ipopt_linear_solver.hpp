// SPDX-License-Identifier: Apache-2.0
// In: Ipopt's linear systems for an Ocp. Out: their solutions, from pivots that its stages tell.
#pragma once

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/sparse_ldl.hpp"

namespace tandem {

/// Pivots for the system of Ipopt's step, unknowns z, slacks of rows (4), λ of (2), (3), then λ of
/// (4), in the order of a Riccati recursion: each row (4) into its stage, then the stages from the
/// last to the first, s, d, X⁺ and a⁺ each against its own row, whose entry is 1, and u at the end.
/// Only the pivots of u depend on the curvature: as in riccati.cpp, they tell its inertia.
[[nodiscard]] std::vector<Pivot> stage_pivots(const Ocp& ocp);

/// Whether this Ipopt lets a linear solver be put in the place of HSL's MA27 (3.11 does).
[[nodiscard]] bool takes_linear_solver();

/// While it lives, Ipopt's `ma27` on this thread is `factors` with pivots `order`.
class AsMa27 {
 public:
  AsMa27(SparseLdl& factors, const std::vector<Pivot>& order);
  ~AsMa27();
  AsMa27(const AsMa27&) = delete;
  AsMa27& operator=(const AsMa27&) = delete;

  /// Whether Ipopt has asked it for factors.
  [[nodiscard]] bool is_used() const;
};

}  // namespace tandem
