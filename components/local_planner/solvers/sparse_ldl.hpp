// SPDX-License-Identifier: Apache-2.0
// In: a sparse symmetric matrix and its pivots. Out: its factors, its inertia, solutions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

/// Which unknowns are eliminated together: one, or two as a pivot of order 2 (`second` ≥ 0).
struct Pivot {
  int first, second = -1;
};

/// P A Pᵀ = L D Lᵀ with pivots fixed beforehand, for matrices whose structure tells where the safe
/// ones are. What can be known of the pattern is worked out once; each factorisation then follows
/// a list of places. No allocation after analyse().
class SparseLdl {
 public:
  /// Pattern of the lower or upper triangle, 1-based; entries that occur twice are added. `order`:
  /// all unknowns 0 … size − 1, each in one pivot. Nothing to do if the pattern is the last one.
  void analyse(int size, std::span<const int> rows, std::span<const int> columns,
               std::span<const Pivot> order);

  /// False if a pivot is singular.
  [[nodiscard]] bool factorize(std::span<const double> values);

  /// Negative eigenvalues of the matrix (Sylvester: those of D).
  [[nodiscard]] int negative() const { return negative_; }

  /// A x = b in place.
  void solve(std::span<double> b);

 private:
  // A pivot's column, or two: places start … end of value_ hold the pivot (a; or a, b, c) and then,
  // for each row below, one value or two.
  struct Block {
    int at;            // first unknown, as permuted
    int width;         // 1 or 2
    int place;         // of the pivot in value_
    int row, row_end;  // its rows in rows_
    int target;        // where its updates begin in targets_
  };

  void order_unknowns(std::span<const Pivot> order);
  void find_rows();
  void place_values();
  [[nodiscard]] int place_of(int row, int column) const;
  void place_updates();
  [[nodiscard]] bool eliminate_one(const Block& block);
  [[nodiscard]] bool eliminate_two(const Block& block);

  int size_ = 0, negative_ = 0;
  std::vector<int> pattern_rows_, pattern_columns_;
  std::vector<int> position_;  // of an unknown, as permuted
  std::vector<int> block_of_;  // of a permuted unknown
  std::vector<Block> blocks_;
  std::vector<int> rows_;              // below the pivots, as permuted, rising
  std::vector<std::int32_t> entries_;  // where each given value goes
  std::vector<std::int32_t> targets_;  // where each update goes
  std::vector<double> value_, column_, x_;
};

}  // namespace tandem
