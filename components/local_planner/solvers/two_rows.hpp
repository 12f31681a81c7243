// SPDX-License-Identifier: Apache-2.0
// Sums over the rows of a problem, two rows at a time: one in each lane of a vector register.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace tandem {

/// Two variables at a time, so that the loops' sums stay in registers.
using Two = Eigen::Array2d;
inline Eigen::Map<Two> two(std::vector<double>& values, std::size_t i) {
  return Eigen::Map<Two>{&values[i]};
}
inline Eigen::Map<const Two> two(const std::vector<double>& values, std::size_t i) {
  return Eigen::Map<const Two>{&values[i]};
}

/// Rows i and i + other. Where a stage ends with row i, other is 0, and both lanes have that row.
inline Two two_rows(const std::vector<double>& values, std::size_t i, std::size_t other) {
  return {values[i], values[i + other]};
}
inline void set_two_rows(std::vector<double>& values, std::size_t i, std::size_t other,
                         const Two& both) {
  values[i + other] = both[1];
  values[i] = both[0];
}

/// Σ weight v, a lane for every second row.
struct VectorSum {
  Two x = Two::Zero(), y = Two::Zero(), t = Two::Zero();

  void add(const Two& weight, const Two& v_x, const Two& v_y, const Two& v_t) {
    x += weight * v_x;
    y += weight * v_y;
    t += weight * v_t;
  }
  [[nodiscard]] Eigen::Vector3d value() const { return {x.sum(), y.sum(), t.sum()}; }
};

/// Σ weight v vᵀ, a lane for every second row.
struct OuterSum {
  Two xx = Two::Zero(), xy = Two::Zero(), yy = Two::Zero();
  Two xt = Two::Zero(), yt = Two::Zero(), tt = Two::Zero();

  void add(const Two& weight, const Two& v_x, const Two& v_y, const Two& v_t) {
    const Two x = weight * v_x, y = weight * v_y;
    xx += x * v_x;
    xy += x * v_y;
    yy += y * v_y;
    xt += x * v_t;
    yt += y * v_t;
    tt += weight * v_t * v_t;
  }
  [[nodiscard]] Eigen::Matrix3d value() const {
    const double x_y = xy.sum(), x_t = xt.sum(), y_t = yt.sum();
    Eigen::Matrix3d all;
    all << xx.sum(), x_y, x_t, x_y, yy.sum(), y_t, x_t, y_t, tt.sum();
    return all;
  }
};

}  // namespace tandem
