// SPDX-License-Identifier: Apache-2.0
// Turns what the person asks for into a nominal trajectory and the cost of each stage.
#pragma once

#include <vector>

#include "tandem/local_planner/nmpc_params.hpp"
#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// Pose of the leader expected in t [s], in the map frame: moved by the person's twist for
/// T (1 − exp(−t / T)), T = leader_preview, because the present twist predicts the later motion
/// less and less. A goal does not move.
[[nodiscard]] Pose2 leader_after(double t, const PlanRequest& request, const NmpcParams& params);

/// The path the leader is expected to take from its present pose, in the map frame [m]: points
/// Trail::kSpacing apart or slightly more.
[[nodiscard]] std::vector<Eigen::Vector2d> leader_onward(const PlanRequest& request,
                                                         const NmpcParams& params);

/// Deceleration limit [m/s²]: a_max, or the hardware limit while the stick asks for far less speed
/// than the command in force, or for the opposite direction.
[[nodiscard]] double braking_of(const PlanRequest& request, const RobotParams& robot);

/// Nominal trajectory: what the robot would do without obstacles, within its limits. For a leader
/// or goal: drive to its expected position, then turn to its heading.
struct Forecast {
  std::vector<Twist2> twist;  ///< N
  std::vector<Pose2> X_MB;    ///< N + 1
};
[[nodiscard]] Forecast forecast(const PlanRequest& request, const Moving& from,
                                const NmpcParams& params, const RobotParams& robot);

/// As forecast(), but by way of the point p_MV [m]: a guess that passes an obstacle on one side.
[[nodiscard]] Forecast forecast_via(const Eigen::Vector2d& p_MV, const PlanRequest& request,
                                    const Moving& from, const NmpcParams& params,
                                    const RobotParams& robot);

/// As forecast(), but toward a constant twist.
[[nodiscard]] Forecast forecast_of(const Twist2& twist, const PlanRequest& request,
                                   const Moving& from, const NmpcParams& params,
                                   const RobotParams& robot);

/// Costs of the N stages, one shape for all methods:
///
///   leader, goal  (x−x_g)ᵀQ(x−x_g) + uᵀRu, heading by 2(1 − cos), faded by 1 / (1 + (d/d₀)²)
///                 with d the distance to X_MG now and d₀ heading_fade: position dominates far
///                 away, heading near the target. x_g is leader_after() of the stage. goal: the
///                 last stage's pose terms count (1 + terminal_weight) times                  (1)
///   intention     rollout: C_v(v_u−v)² + C_v(ω_u−ω)² + C_h 2(1 − cos(θ_u−θ)) + C_p|p_u−p|²
///                 + C_c|Δu−Δu_u|², with X_u and Δu_u from the forecast (v_u, ω_u reached at the
///                 acceleration limits): if nothing blocks, the forecast is the optimum       (2)
///                 atan: C_v(v_u−v)² + C_h 2(1 − cos(atan(ω_u/v_u) − atan(ω/v))) + C_c|Δu|²   (3)
///                 both fade over the horizon: the person's present command is the most certain
///   path          (1) toward a point of the trail slightly ahead of the forecast at that stage,
///                 with Q = R diag(along, across) Rᵀ in the frame R of the trail there:
///                 contouring and lag error (Lam, Manzie and Good 2010; Liniger, Domahidi and
///                 Morari 2015). Q = 0 where an obstacle interrupts the trail                (4)
[[nodiscard]] std::vector<StageCost> stage_costs(const PlanRequest& request,
                                                 const Forecast& nominal, const NmpcParams& params,
                                                 const RobotParams& robot);

/// Bound on the cost that one metre of motion at X_MB can save [1/m]: Σ |∂cost/∂p| + |∂cost/∂v| /
/// (N Δt). The slack penalty is exact if its weight exceeds the multipliers of the rows. This pull
/// bounds them as long as one row constrains all stages with a sensitivity of about one.
[[nodiscard]] double pull(const std::vector<StageCost>& costs, const Pose2& X_MB, double dt);

}  // namespace tandem
