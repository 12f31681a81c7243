// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/distance_transform.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// h_i(y)² of (1) for every cell: one pass up and one pass down each column, row by row.
std::vector<double> squared_column_gaps(const std::vector<std::uint8_t>& is_obstacle,
                                        std::size_t width, std::size_t height) {
  std::vector<double> steps(is_obstacle.size());  // to the nearest obstacle cell of the column
  std::vector<double> last(width, kUnbounded);
  const auto sweep = [&](std::size_t y, bool first) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t i = y * width + x;
      last[x] = is_obstacle[i] ? 0.0 : last[x] + 1.0;
      steps[i] = first ? last[x] : std::min(steps[i], last[x]);
    }
  };
  for (std::size_t y = 0; y < height; ++y) sweep(y, true);
  std::fill(last.begin(), last.end(), kUnbounded);
  for (std::size_t y = height; y-- > 0;) sweep(y, false);
  for (double& step : steps) {
    const double gap = std::max(0.0, step - 0.5);
    step = gap * gap;
  }
  return steps;
}

// Lower envelope of parabolas (x − foot)² + height, added with ascending feet.
class Envelope {
 public:
  explicit Envelope(std::size_t most) {
    parabolas_.reserve(most);
    starts_.reserve(most);
  }
  void clear() {
    parabolas_.clear();
    starts_.clear();
  }
  void add(double foot, double height) {
    if (height == kUnbounded) return;
    double start = -kUnbounded;
    while (!parabolas_.empty()) {
      const auto& last = parabolas_.back();
      start = 0.5 * (foot + last.foot) + 0.5 * (height - last.height) / (foot - last.foot);
      if (start > starts_.back()) break;
      parabolas_.pop_back();
      starts_.pop_back();
      start = -kUnbounded;
    }
    parabolas_.push_back({foot, height});
    starts_.push_back(start);
  }
  // Value at x; call with ascending x and a cursor that starts at 0.
  [[nodiscard]] double at(double x, std::size_t& cursor) const {
    if (parabolas_.empty()) return kUnbounded;
    while (cursor + 1 < parabolas_.size() && starts_[cursor + 1] <= x) ++cursor;
    const double d = x - parabolas_[cursor].foot;
    return d * d + parabolas_[cursor].height;
  }

 private:
  struct Parabola {
    double foot, height;
  };
  std::vector<Parabola> parabolas_;
  std::vector<double> starts_;  // x from which each parabola is the lowest
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
    std::size_t cursor = 0;
    for (std::size_t x = 0; x < columns; ++x)
      row[x] = std::sqrt(std::min(row[x], edges.at(static_cast<double>(x), cursor)));  // (1)
  }
  return result;
}

}  // namespace tandem
