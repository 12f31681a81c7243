// SPDX-License-Identifier: Apache-2.0
// The planner's optimal control problem as a nonlinear programme with exact derivatives.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/model/motor_lag.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Cost weights and targets of one stage, with the symbols of (1).
struct StageCost {
  Pose2 X_MR;                   ///< target pose at the end of the stage
  Twist2 twist;                 ///< target twist
  Twist2 change;                ///< target change of the twist
  double q_x = 0.0, q_y = 0.0;  ///< position
  double q_xy = 0.0;            ///< position, off-diagonal: weights in a frame rotated against M
  double q_theta = 0.0;         ///< heading
  double r_v = 0.0, r_w = 0.0;  ///< twist
  double c_v = 0.0, c_w = 0.0;  ///< change of the twist
  double c_dir = 0.0, direction = 0.0;  ///< Krijnen's term: preferred direction of (v, w)

  /// Half the gradient of the position cost; `off`: offset from the target position [m].
  [[nodiscard]] Eigen::Vector2d pull(const Eigen::Vector2d& off) const {
    return {q_x * off.x() + q_xy * off.y(), q_xy * off.x() + q_y * off.y()};
  }
};

/// One disc of the robot and one obstacle that it must stay clear of at the end of a stage.
struct Pair {
  Eigen::Vector2d p_BC;  ///< centre of the disc [m]
  double gap;            ///< its radius plus the margin [m]
  Obstacle obstacle;     ///< at its predicted position
  std::uint32_t disc;  ///< index of the disc; with obstacle.id it identifies the pair across cycles
};

struct Stage {
  StageCost cost;
  std::vector<Pair> pairs;
};

struct Interval {
  double min, max;
};

/// The optimal control problem of one cycle, multiple shooting over stages k = 0 … N−1. Stage k
/// owns the variables u = (v, w), its change d, the pose X⁺ at its end and one slack s ≥ 0:
///
///   z_k = (v, w, d_v, d_w, x⁺, y⁺, θ⁺, s)
///
/// minimise Σ q_x (x⁺−x_r)² + 2 q_xy (x⁺−x_r) (y⁺−y_r) + q_y (y⁺−y_r)² + 2 q_θ (1 − cos(θ⁺−θ_r))
///          + r_v (v−v_r)² + r_w (w−w_r)² + c_v (d_v−d_vr)² + c_w (d_w−d_wr)²
///          + 2 c_dir (1 − cos∠((v, w), direction)) + ρ s                                  (1)
/// subject to
///   u_k − u_{k−1} − d_k = 0,       u_{−1} the command in force                              (2)
///   X⁺ − f(X, m) = 0,              X of stage 0 the predicted pose, m the mean twist        (3)
///   φ(C(X⁺)) − gap − g_v v² − g_w w² + s ≥ 0   per pair, φ of signed_distance.hpp           (4)
///   bounds on u, d, x⁺, y⁺, s
///
/// where f moves along an arc (γ = 0 gives Euler's step, [T] 3.10), with the displacement
///   v Δt sinc(γ w) (cos(θ + γ w), sin(θ + γ w)),   γ = Δt / 2                               (5)
///
/// Without motor lag, m = u. With it, a stage has two more variables at the end of its block,
/// a⁺ = (a_v, a_w), the robot's actual twist at the end of the stage, and two more rows,
///
///   a⁺ − E a − (1 − E) u = 0,   m = φ a + (1 − φ) u,   E, φ of motor_lag.hpp over Δt         (8)
///
/// where a of stage 0 is the actual twist at its start. Limits and costs apply to the command u.
///
/// The speed-dependent margin g_v v² + g_w w² of (4) grows like the stopping distance, so the robot
/// slows down beside obstacles. The penalty is exact, s = 0 wherever that is feasible, if ρ exceeds
/// the sum of each stage's multipliers of (4). The pose of stage 0 is data, not a variable.
/// (2), (3) and (8) couple neighbouring stages only.
struct Ocp {
  double dt = 0.25;                                    ///< Δt [s]
  double half = 0.125;                                 ///< γ [s]
  double slack_weight = 500.0;                         ///< ρ
  double gap_v = 0.0, gap_w = 0.0;                     ///< g_v [s²/m], g_w [m s²/rad²]
  Pose2 X_MB = {};                                     ///< pose of stage 0
  Twist2 command = {};                                 ///< u_{−1}
  LagStep lag = {};                                    ///< E, φ
  Twist2 motion = {};                                  ///< a of stage 0; unused without a lag
  std::vector<Interval> v = {}, w = {};                ///< bounds of u, per stage
  std::vector<Interval> change_v = {}, change_w = {};  ///< bounds of d, per stage
  double workspace = 0.0;                              ///< bound of |x⁺|, |y⁺| [m]; 0: none
  std::vector<Stage> stages = {};

  [[nodiscard]] int horizon() const { return static_cast<int>(stages.size()); }
};

/// Index of each variable within its stage's block. The last two exist only with a motor lag.
enum Place : int { kV, kW, kDv, kDw, kX, kY, kTheta, kSlack, kMotionV, kMotionW };
/// Variables and equality rows per stage; the rows are (2), (2), (3), (3), (3) and with a lag (8),
/// (8). The equality rows of all stages precede the rows (4). `n`: states passed to the next stage,
/// 3, or 5 with a lag.
[[nodiscard]] constexpr std::size_t block_of(std::size_t n) { return 5 + n; }
[[nodiscard]] constexpr std::size_t equalities_of(std::size_t n) { return 2 + n; }
[[nodiscard]] inline std::size_t states(const Ocp& ocp) { return ocp.lag.any() ? 5 : 3; }
[[nodiscard]] inline std::size_t block(const Ocp& ocp) { return block_of(states(ocp)); }
[[nodiscard]] inline std::size_t equalities(const Ocp& ocp) { return equalities_of(states(ocp)); }

[[nodiscard]] int variables(const Ocp& ocp);
[[nodiscard]] int rows(const Ocp& ocp);

/// Variable `place` of stage k.
[[nodiscard]] inline double at(const Ocp& ocp, std::span<const double> z, std::size_t k,
                               Place place) {
  return z[block(ocp) * k + place];
}
/// Commanded twist of stage k.
[[nodiscard]] inline Twist2 twist_of(const Ocp& ocp, std::span<const double> z, std::size_t k) {
  return {at(ocp, z, k, kV), at(ocp, z, k, kW)};
}
/// Pose at the end of stage k.
[[nodiscard]] inline Pose2 pose_after(const Ocp& ocp, std::span<const double> z, std::size_t k) {
  return {at(ocp, z, k, kX), at(ocp, z, k, kY), at(ocp, z, k, kTheta)};
}
/// Pose and actual twist of the robot at the start of stage k.
[[nodiscard]] Moving moving_before(const Ocp& ocp, std::span<const double> z, std::size_t k);

/// Bounds of variables and rows; ±kUnbounded means no bound.
inline constexpr double kUnbounded = 1e20;
struct Bounds {
  std::vector<Interval> variable, row;
};
[[nodiscard]] Bounds bounds(const Ocp& ocp);

/// Row and column of each nonzero, in the order in which the functions below write the values.
struct Entry {
  int row, column;
};
[[nodiscard]] std::vector<Entry> jacobian_pattern(const Ocp& ocp);
[[nodiscard]] std::vector<Entry> hessian_pattern(const Ocp& ocp);  ///< lower triangle

/// Values at z, written into the solver's arrays. λ: multipliers of the rows; the Hessian is that
/// of σ cost + λᵀ rows.
[[nodiscard]] double cost(const Ocp& ocp, std::span<const double> z);
void cost_gradient(const Ocp& ocp, std::span<const double> z, std::span<double> gradient);
void row_values(const Ocp& ocp, std::span<const double> z, std::span<double> values);
void jacobian_values(const Ocp& ocp, std::span<const double> z, std::span<double> values);
void hessian_values(const Ocp& ocp, std::span<const double> z, double sigma,
                    std::span<const double> lambda, std::span<double> values);

/// φ − gap of (4) at a pose [m]; negative if the margin is violated.
[[nodiscard]] double clearance(const Pair& pair, const Pose2& X_MB);

/// Speed-dependent margin g_v v² + g_w w² of (4) [m].
[[nodiscard]] double speed_margin(const Ocp& ocp, const Twist2& twist);

/// f of (3), by (5); the heading is not wrapped.
[[nodiscard]] Pose2 advance(const Ocp& ocp, const Pose2& X_MB, const Twist2& mean);

/// State after one stage with command `u`, by (3) and (8).
[[nodiscard]] Moving advance(const Ocp& ocp, const Moving& from, const Twist2& u);

}  // namespace tandem
