// SPDX-License-Identifier: Apache-2.0
// Private to local_planner: evaluates a problem's pairs in SIMD lanes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "tandem/local_planner/ocp/distance_batch.hpp"
#include "tandem/local_planner/ocp/stage_terms.hpp"

namespace tandem {

/// pair_terms() of all rows (4), one array per member, so that several are used at once. A few
/// finite values follow those of the last row: any two neighbours can be loaded.
struct PairTable {
  std::vector<double> value, n_x, n_y, turn, lean, curvature;

  void resize(std::size_t pair_count);
  [[nodiscard]] PairTerms operator[](std::size_t i) const {
    return {value[i], n_x[i], n_y[i], turn[i], lean[i], curvature[i]};
  }
};

/// Up to eight consecutive pairs, i.e. rows (4) of an Ocp, possibly of several stages.
class PairBatch {
 public:
  static constexpr std::size_t kLanes = 8;

  [[nodiscard]] bool has_room() const { return count_ < kLanes; }
  void add(const Pair& pair, std::size_t stage);
  [[nodiscard]] std::size_t count() const { return count_; }

  /// Writes pair_terms() of each pair, in the order added, to the rows from `first` on, and finite
  /// values to the rows of unused lanes. X: poses at the ends of all stages.
  void terms(std::span<const Placed> X, std::size_t first, PairTable& out) const;

 private:
  using All = Lanes<int{kLanes}>;

  /// Distance from the outline of points that are at `d` from the obstacles' centres, in axes of M.
  [[nodiscard]] OutlineDistance<int{kLanes}> distance(const All& d_x, const All& d_y) const;
  [[nodiscard]] OutlineDistance<int{kLanes}> distance_in_axes(const All& q_x, const All& q_y) const;

  // Initialised so that unused lanes compute finite values.
  All a_ = All::Ones(), b_ = All::Ones(), axis_c_ = All::Ones(), axis_s_ = All::Zero();
  All p_x_ = All::Zero(), p_y_ = All::Zero();      // obstacles' centres in M [m]
  All arm_x_ = All::Zero(), arm_y_ = All::Zero();  // discs' centres in B [m]
  All gap_ = All::Zero();
  Eigen::Array<bool, int{kLanes}, 1> is_rectangle_ = Eigen::Array<bool, int{kLanes}, 1>::Zero();
  bool has_ellipse_ = false, has_rectangle_ = false;  // otherwise all are circles
  std::array<std::size_t, kLanes> stage_{};
  std::size_t count_ = 0;
};

}  // namespace tandem
