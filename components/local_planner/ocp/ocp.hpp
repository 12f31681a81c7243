// SPDX-License-Identifier: Apache-2.0
// In: predicted pose, references, nearby obstacles. Out: one nonlinear programme with derivatives.
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

/// Weights and targets of the cost of one stage, symbols of (1).
struct StageCost {
  Pose2 X_MR;                           ///< target pose of the stage's end
  Twist2 twist;                         ///< target twist
  Twist2 change;                        ///< target change of the twist
  double q_x = 0.0, q_y = 0.0;          ///< position
  double q_xy = 0.0;                    ///< … off the diagonal: another frame than the map's
  double q_theta = 0.0;                 ///< heading
  double r_v = 0.0, r_w = 0.0;          ///< twist
  double c_v = 0.0, c_w = 0.0;          ///< change of the twist
  double c_dir = 0.0, direction = 0.0;  ///< Krijnen's wish: direction of (v, w) in the twist plane

  /// Derivative of the position's cost by the position, ½ of it.
  [[nodiscard]] Eigen::Vector2d pull(const Eigen::Vector2d& off) const {
    return {q_x * off.x() + q_xy * off.y(), q_xy * off.x() + q_y * off.y()};
  }
};

/// One disc of the robot that has to stay clear of one obstacle at the end of a stage.
struct Pair {
  Eigen::Vector2d p_BC;  ///< the disc's centre
  double gap;            ///< its radius plus the margin [m]
  Obstacle obstacle;     ///< at its predicted place
  std::uint32_t disc;    ///< which disc: with obstacle.id, what the pair is remembered by
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
///   φ(C(X⁺)) − gap − g_v v² − g_w w² + s ≥ 0   per pair, φ of ellipse_distance.hpp           (4)
///   bounds on u, d, x⁺, y⁺, s
///
/// with the displacement of f along the arc, or γ = 0 for Euler's step ([T] 3.10):
///   v Δt sinc(γ w) (cos(θ + γ w), sin(θ + γ w)),   γ = Δt / 2                               (5)
///
/// A robot that follows at once moves by m = u. One whose motors lag has two more variables at the
/// end of its block, a⁺ = (a_v, a_w), the twist it then moves with, and two more rows (3),
///
///   a⁺ − E a − (1 − E) u = 0,   m = φ a + (1 − φ) u,   E, φ of motor_lag.hpp over Δt         (8)
///
/// with a of stage 0 the twist it moves with there. Limits and costs are those of the command.
///
/// The gap of (4) grows as the way to standstill does: fast far from obstacles, slow beside them.
/// ρ above every multiplier of (4) makes the penalty exact: s = 0 whenever that is possible.
/// The pose of stage 0 is data, not a variable. (2), (3) chain the stages: neighbours only.
struct Ocp {
  double dt = 0.25;                                    ///< Δt [s]
  double half = 0.125;                                 ///< γ [s]
  double slack_weight = 500.0;                         ///< ρ
  double gap_v = 0.0, gap_w = 0.0;                     ///< g_v [s²/m], g_w [m s²/rad²]
  Pose2 X_MB = {};                                     ///< pose of stage 0
  Twist2 command = {};                                 ///< u_{−1}
  LagStep lag = {};                                    ///< E, φ
  Twist2 motion = {};                                  ///< a of stage 0; not read without a lag
  std::vector<Interval> v = {}, w = {};                ///< bounds of u, per stage
  std::vector<Interval> change_v = {}, change_w = {};  ///< bounds of d, per stage
  double workspace = 0.0;                              ///< bound of |x⁺|, |y⁺|; 0: none
  std::vector<Stage> stages = {};

  [[nodiscard]] int horizon() const { return static_cast<int>(stages.size()); }
};

/// Places of a stage's variables in its block. The last two: of a robot whose motors lag.
enum Place : int { kV, kW, kDv, kDw, kX, kY, kTheta, kSlack, kMotionV, kMotionW };
/// Length of a block, and equality rows of a stage: (2), (2), (3), (3), (3), with a lag (8), (8).
/// All of them come before the rows (4). `n`: states that a stage hands on, 3, or 5 with a lag.
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
/// Twist commanded in stage k, of variables z.
[[nodiscard]] inline Twist2 twist_of(const Ocp& ocp, std::span<const double> z, std::size_t k) {
  return {at(ocp, z, k, kV), at(ocp, z, k, kW)};
}
/// Pose at the end of stage k, of variables z.
[[nodiscard]] inline Pose2 pose_after(const Ocp& ocp, std::span<const double> z, std::size_t k) {
  return {at(ocp, z, k, kX), at(ocp, z, k, kY), at(ocp, z, k, kTheta)};
}
/// Pose and twist of the robot at the start of stage k, of variables z.
[[nodiscard]] Moving moving_before(const Ocp& ocp, std::span<const double> z, std::size_t k);

/// Bounds of variables and rows; ±kUnbounded where there is none.
inline constexpr double kUnbounded = 1e20;
struct Bounds {
  std::vector<Interval> variable, row;
};
[[nodiscard]] Bounds bounds(const Ocp& ocp);

/// Row and column of each entry that the values below fill, in their order.
struct Entry {
  int row, column;
};
[[nodiscard]] std::vector<Entry> jacobian_pattern(const Ocp& ocp);
[[nodiscard]] std::vector<Entry> hessian_pattern(const Ocp& ocp);  ///< lower triangle

/// Values at z, written where the solver keeps them. λ: multipliers of the rows; the Hessian is
/// that of σ cost + λᵀ rows.
[[nodiscard]] double cost(const Ocp& ocp, std::span<const double> z);
void cost_gradient(const Ocp& ocp, std::span<const double> z, std::span<double> gradient);
void row_values(const Ocp& ocp, std::span<const double> z, std::span<double> values);
void jacobian_values(const Ocp& ocp, std::span<const double> z, std::span<double> values);
void hessian_values(const Ocp& ocp, std::span<const double> z, double sigma,
                    std::span<const double> lambda, std::span<double> values);

/// φ − gap of (4) at a pose [m]: negative where the margin is missed.
[[nodiscard]] double clearance(const Pair& pair, const Pose2& X_MB);

/// g_v v² + g_w w² of (4) [m].
[[nodiscard]] double growth(const Ocp& ocp, const Twist2& twist);

/// f of (5), with the heading not wrapped.
[[nodiscard]] Pose2 advance(const Ocp& ocp, const Pose2& X_MB, const Twist2& mean);

/// (3) and (8): the state after a stage of the command `u`.
[[nodiscard]] Moving advance(const Ocp& ocp, const Moving& from, const Twist2& u);

}  // namespace tandem
