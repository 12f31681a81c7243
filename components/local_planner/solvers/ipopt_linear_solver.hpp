// SPDX-License-Identifier: Apache-2.0
// Solves Ipopt's linear systems for an Ocp with a pivot order derived from its stages.
#pragma once

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/sparse_ldl.hpp"

namespace tandem {

/// Pivots for the KKT system of Ipopt's step, whose unknowns are z, the slacks of rows (4), λ of
/// (2), (3), (8), then λ of (4). The order is that of a Riccati recursion: first the rows (4) are
/// eliminated into their stages, then the stages from last to first. In a stage s comes first, then
/// d, X⁺ and a⁺, each paired with its own row, whose entry is ±1, and u last. Only the pivots of u
/// depend on the curvature; as in riccati.cpp, they determine the inertia.
[[nodiscard]] std::vector<Pivot> stage_pivots(const Ocp& ocp);

/// Whether this Ipopt lets HSL's MA27 be replaced by another solver (3.11 does).
[[nodiscard]] bool takes_linear_solver();

/// During its lifetime, Ipopt's `ma27` on this thread uses `factors` with the pivots `order`, both
/// of which must outlive it.
class AsMa27 {
 public:
  AsMa27(SparseLdl& factors, const std::vector<Pivot>& order);
  ~AsMa27();
  AsMa27(const AsMa27&) = delete;
  AsMa27& operator=(const AsMa27&) = delete;

  /// Whether Ipopt has requested a factorisation.
  [[nodiscard]] bool is_used() const;
};

}  // namespace tandem
