// SPDX-License-Identifier: Apache-2.0
// LDLᵀ factorisation of sparse symmetric indefinite matrices with a fixed pivot order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

/// Unknowns eliminated together: one, or two as a pivot of order 2 (`second` ≥ 0).
struct Pivot {
  int first, second = -1;
};

/// P A Pᵀ = L D Lᵀ with pivots chosen beforehand, for matrices whose structure determines safe
/// pivots. analyse() does the symbolic work once; factorisations then follow precomputed indices
/// and allocate nothing.
class SparseLdl {
 public:
  /// Pattern of the lower or upper triangle, 1-based; duplicate entries are added. `order`: all
  /// unknowns 0 … size − 1, each in one pivot. Does nothing if the pattern equals that of the last
  /// call; `order` is not compared.
  void analyse(int size, std::span<const int> rows, std::span<const int> columns,
               std::span<const Pivot> order);

  /// Returns false if a pivot is singular or not finite.
  [[nodiscard]] bool factorize(std::span<const double> values);

  /// Negative eigenvalues of the matrix (by Sylvester's law, those of D).
  [[nodiscard]] int negative() const { return negative_; }

  /// A x = b in place.
  void solve(std::span<double> b);

 private:
  // The column or columns of a pivot. From `place` on, value_ holds the pivot (a, or a, b, c), then
  // one or two values for each row below.
  struct Block {
    int at;            // first unknown, permuted
    int width;         // 1 or 2
    int place;         // index of the pivot in value_
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
  std::vector<int> position_;  // permuted index of an unknown
  std::vector<int> block_of_;  // block of a permuted unknown
  std::vector<Block> blocks_;
  std::vector<int> rows_;              // below the pivots, permuted, ascending
  std::vector<std::int32_t> entries_;  // index in value_ of each matrix entry
  std::vector<std::int32_t> targets_;  // index in value_ of each update
  std::vector<double> value_, column_, x_;
};

}  // namespace tandem
