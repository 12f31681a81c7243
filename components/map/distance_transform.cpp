// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/distance_transform.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr int kNone = 1 << 29;  // this many steps or more: no obstacle cell in the column

// h_i(y)² of (1) for every cell: one pass up and one pass down each column, row by row.
std::vector<double> squared_column_gaps(const std::vector<std::uint8_t>& is_obstacle,
                                        std::size_t width, std::size_t height) {
  std::vector<int> up(is_obstacle.size());  // steps to the last obstacle cell in the rows so far
  std::vector<int> last(width, kNone);      // likewise, of the previous row
  for (std::size_t y = 0, i = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x, ++i) up[i] = last[x] = is_obstacle[i] ? 0 : last[x] + 1;
  std::vector<double> squares(is_obstacle.size());
  std::fill(last.begin(), last.end(), kNone);
  for (std::size_t y = height; y-- > 0;)
    for (std::size_t x = 0, i = y * width; x < width; ++x, ++i) {
      last[x] = is_obstacle[i] ? 0 : last[x] + 1;
      const int steps = std::min(up[i], last[x]);
      const double gap = std::max(0.0, steps - 0.5);
      squares[i] = steps >= kNone ? kUnbounded : gap * gap;
    }
  return squares;
}

// Lower envelope of parabolas (x − foot)² + height over x ≥ 0, added with ascending feet.
class Envelope {
 public:
  explicit Envelope(std::size_t most) : parabolas_(most) {}
  void clear() { count_ = 0; }
  void add(double foot, double height) {
    if (height == kUnbounded) return;
    // A parabola that is nowhere the lowest is removed. At its start the comparison needs no
    // division.
    while (count_ > 0) {
      const Parabola& last = parabolas_[count_ - 1];
      const double to_new = last.start - foot, to_last = last.start - last.foot;
      if (to_new * to_new + height > to_last * to_last + last.height) break;
      --count_;
    }
    double start = 0.0;
    if (count_ > 0) {
      const Parabola& last = parabolas_[count_ - 1];
      start = 0.5 * (foot + last.foot + (height - last.height) / (foot - last.foot));
    }
    parabolas_[count_++] = {foot, height, start};
  }
  // values[x] = the smaller of itself and of the envelope at x.
  void lower(double* values, std::size_t width) const {
    for (std::size_t i = 0, x = 0; i < count_; ++i) {
      const double end = i + 1 < count_ ? parabolas_[i + 1].start : kUnbounded;
      const Parabola& lowest = parabolas_[i];
      for (; x < width && static_cast<double>(x) < end; ++x) {
        const double d = static_cast<double>(x) - lowest.foot;
        values[x] = std::min(values[x], d * d + lowest.height);
      }
    }
  }

 private:
  struct Parabola {
    double foot, height;
    double start;  // x from which it is the lowest
  };
  std::vector<Parabola> parabolas_;
  std::size_t count_ = 0;
};

}  // namespace

std::vector<double> distance_transform(const std::vector<std::uint8_t>& is_obstacle, int width,
                                       int height) {
  const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
  std::vector<double> result = squared_column_gaps(is_obstacle, columns, rows);
  Envelope edges(columns + 1);
  for (std::size_t y = 0; y < rows && columns > 0; ++y) {
    double* const row = result.data() + y * columns;
    edges.clear();
    edges.add(-0.5, row[0]);
    for (std::size_t x = 0; x < columns; ++x)
      edges.add(static_cast<double>(x) + 0.5,
                std::min(row[x], x + 1 < columns ? row[x + 1] : kUnbounded));
    edges.lower(row, columns);
    for (std::size_t x = 0; x < columns; ++x) row[x] = std::sqrt(row[x]);  // (1)
  }
  return result;
}

// All sums are multiples of ¼ far below 2²², which floats represent exactly.
std::vector<float> distance_transform(const std::vector<std::uint8_t>& is_obstacle, int width,
                                      int height, int most) {
  using Row = Eigen::ArrayXf;
  using Plane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto far = static_cast<float>(most) + 1.0F;
  const Eigen::Map<
      const Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
      obstacle{is_obstacle.data(), height, width};
  Plane steps(height, width);  // along the column to the nearest obstacle cell, at most `far`
  Row last = Row::Constant(width, far);
  const auto step = [&](int y) {
    last = (1.0F - obstacle.row(y).cast<float>().transpose()) * (last + 1.0F).min(far);
  };
  for (int y = 0; y < height; ++y) {
    step(y);
    steps.row(y) = last.transpose();
  }
  last.setConstant(far);
  std::vector<float> result(is_obstacle.size());
  Row padded = Row::Constant(width + 2 * most, far * far);
  for (int y = height - 1; y >= 0; --y) {
    step(y);
    auto own = padded.segment(most, width);
    own = (last.min(steps.row(y).transpose()) - 0.5F).max(0.0F).square();
    Eigen::Map<Row> row{result.data() + static_cast<std::ptrdiff_t>(y) * width, width};
    row = own;
    for (int k = 1; k <= most; ++k) {
      const float gap = (static_cast<float>(k) - 0.5F) * (static_cast<float>(k) - 0.5F);
      row =
          row.min(padded.segment(most - k, width) + gap).min(padded.segment(most + k, width) + gap);
    }
    // (1); Eigen's square root of floats is an approximation
    row = row.cast<double>().sqrt().cast<float>().min(static_cast<float>(most));
  }
  return result;
}

}  // namespace tandem
