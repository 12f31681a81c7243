// SPDX-License-Identifier: Apache-2.0
// Right-looking: eliminating a pivot D with rows V below it stores L = V D⁻¹ over V and subtracts
// V D⁻¹ Vᵀ from the remaining matrix, whose pattern includes the fill-in.
#include "tandem/local_planner/solvers/sparse_ldl.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr double kSingular = 1e-14;  // absolute for order 1; relative to its products for order 2

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void SparseLdl::analyse(int size, std::span<const int> rows, std::span<const int> columns,
                        std::span<const Pivot> order) {
  if (size == size_ && std::ranges::equal(rows, pattern_rows_) &&
      std::ranges::equal(columns, pattern_columns_))
    return;
  size_ = size;
  pattern_rows_.assign(rows.begin(), rows.end());
  pattern_columns_.assign(columns.begin(), columns.end());
  order_unknowns(order);
  find_rows();
  place_values();
  place_updates();
  x_.resize(at(size));
}

void SparseLdl::order_unknowns(std::span<const Pivot> order) {
  blocks_.clear();
  position_.resize(at(size_));
  block_of_.resize(at(size_));
  int next = 0;
  for (const Pivot& pivot : order) {
    Block block{};
    block.at = next;
    block.width = pivot.second < 0 ? 1 : 2;
    for (const int unknown : {pivot.first, pivot.second}) {
      if (unknown < 0) continue;
      block_of_[at(next)] = static_cast<int>(blocks_.size());
      position_[at(unknown)] = next++;
    }
    blocks_.push_back(block);
  }
}

// Symbolic factorisation: the rows of a block are those of its own entries and those passed on by
// its children in the elimination tree.
void SparseLdl::find_rows() {
  std::vector<std::vector<int>> below(blocks_.size());
  for (std::size_t i = 0; i < pattern_rows_.size(); ++i) {
    const int a = position_[at(pattern_rows_[i] - 1)], b = position_[at(pattern_columns_[i] - 1)];
    const int block = block_of_[at(std::min(a, b))];
    if (block != block_of_[at(std::max(a, b))]) below[at(block)].push_back(std::max(a, b));
  }
  rows_.clear();
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    std::vector<int>& list = below[i];
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    blocks_[i].row = static_cast<int>(rows_.size());
    rows_.insert(rows_.end(), list.begin(), list.end());
    blocks_[i].row_end = static_cast<int>(rows_.size());
    if (list.empty()) continue;
    const int parent = block_of_[at(list.front())];
    for (const int row : list)
      if (block_of_[at(row)] != parent) below[at(parent)].push_back(row);
    list = {};
  }
}

void SparseLdl::place_values() {
  int place = 0, most_rows = 0;
  for (Block& block : blocks_) {
    const int count = block.row_end - block.row;
    block.place = place;
    place += block.width * (block.width + 1) / 2 + block.width * count;
    most_rows = std::max(most_rows, count);
  }
  value_.resize(at(place));
  column_.resize(2 * at(most_rows));
  entries_.resize(pattern_rows_.size());
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const int a = position_[at(pattern_rows_[i] - 1)], b = position_[at(pattern_columns_[i] - 1)];
    entries_[i] = place_of(std::max(a, b), std::min(a, b));
  }
}

int SparseLdl::place_of(int row, int column) const {
  const Block& block = blocks_[at(block_of_[at(column)])];
  const int within = column - block.at;
  if (row < block.at + block.width) return block.place + within + (row - block.at);
  const auto first = rows_.begin() + block.row, last = rows_.begin() + block.row_end;
  const auto index = static_cast<int>(std::lower_bound(first, last, row) - first);
  return block.place + block.width * (block.width + 1) / 2 + block.width * index + within;
}

void SparseLdl::place_updates() {
  targets_.clear();
  for (Block& block : blocks_) {
    block.target = static_cast<int>(targets_.size());
    for (int k = block.row; k < block.row_end; ++k)
      for (int i = k; i < block.row_end; ++i)
        targets_.push_back(place_of(rows_[at(i)], rows_[at(k)]));
  }
}

bool SparseLdl::factorize(std::span<const double> values) {
  std::fill(value_.begin(), value_.end(), 0.0);
  for (std::size_t i = 0; i < entries_.size(); ++i) value_[at(entries_[i])] += values[i];
  negative_ = 0;
  for (const Block& block : blocks_)
    if (!(block.width == 1 ? eliminate_one(block) : eliminate_two(block))) return false;
  return true;
}

bool SparseLdl::eliminate_one(const Block& block) {
  double* const v = &value_[at(block.place)];
  const double pivot = *v;
  if (!(std::abs(pivot) > kSingular) || !std::isfinite(pivot)) return false;
  negative_ += pivot < 0.0 ? 1 : 0;
  const double per = *v = 1.0 / pivot;
  const int count = block.row_end - block.row;
  double *const below = v + 1, *const scaled = column_.data();
  for (int i = 0; i < count; ++i) scaled[i] = per * below[i];
  const std::int32_t* target = targets_.data() + block.target;
  for (int k = 0; k < count; ++k) {
    const double by = below[k];
    for (int i = k; i < count; ++i) value_[at(*target++)] -= by * scaled[i];
  }
  std::copy(scaled, scaled + count, below);
  return true;
}

bool SparseLdl::eliminate_two(const Block& block) {
  double* const v = &value_[at(block.place)];
  const double a = v[0], b = v[1], c = v[2], product = a * c, determinant = product - b * b;
  if (!(std::abs(determinant) > kSingular * std::max(std::abs(product), b * b)) ||
      !std::isfinite(determinant))
    return false;
  negative_ += determinant < 0.0 ? 1 : a < 0.0 ? 2 : 0;
  const double per = 1.0 / determinant, aa = v[0] = per * c, ab = v[1] = -per * b,
               cc = v[2] = per * a;
  const int count = block.row_end - block.row;
  double *const below = v + 3, *const scaled = column_.data();
  for (int i = 0; i < count; ++i) {
    const double first = below[2 * i], second = below[2 * i + 1];
    scaled[2 * i] = aa * first + ab * second;
    scaled[2 * i + 1] = ab * first + cc * second;
  }
  const std::int32_t* target = targets_.data() + block.target;
  for (int k = 0; k < count; ++k) {
    const double first = below[2 * k], second = below[2 * k + 1];
    for (int i = k; i < count; ++i)
      value_[at(*target++)] -= first * scaled[2 * i] + second * scaled[2 * i + 1];
  }
  std::copy(scaled, scaled + 2 * count, below);
  return true;
}

void SparseLdl::solve(std::span<double> b) {
  for (std::size_t i = 0; i < b.size(); ++i) x_[at(position_[i])] = b[i];
  for (const Block& block : blocks_) {  // L, then D
    double* const x = &x_[at(block.at)];
    const double* v = &value_[at(block.place)];
    const int *row = rows_.data() + block.row, *const end = rows_.data() + block.row_end;
    if (block.width == 1) {
      const double by = x[0], per = *v++;
      for (; row != end; ++row) x_[at(*row)] -= by * *v++;
      x[0] = per * by;
    } else {
      const double first = x[0], second = x[1], aa = v[0], ab = v[1], cc = v[2];
      for (v += 3; row != end; ++row, v += 2) x_[at(*row)] -= first * v[0] + second * v[1];
      x[0] = aa * first + ab * second;
      x[1] = ab * first + cc * second;
    }
  }
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {  // Lᵀ
    const double* v = &value_[at(block->place + block->width * (block->width + 1) / 2)];
    double first = 0.0, second = 0.0;
    for (int i = block->row; i < block->row_end; ++i) {
      const double below = x_[at(rows_[at(i)])];
      first += *v++ * below;
      if (block->width == 2) second += *v++ * below;
    }
    x_[at(block->at)] -= first;
    if (block->width == 2) x_[at(block->at + 1)] -= second;
  }
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = x_[at(position_[i])];
}

}  // namespace tandem
