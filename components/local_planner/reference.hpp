// SPDX-License-Identifier: Apache-2.0
// In: what the person wants. Out: the cost of each stage.
#pragma once

#include <vector>

#include "tandem/local_planner/nmpc_params.hpp"
#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// Where the leader is expected t seconds on if the person goes on driving it as now: moved by the
/// person's twist for T (1 − exp(−t / T)), T = leader_preview, for what the person does now says
/// less and less of later. A goal stays where it is.
[[nodiscard]] Pose2 leader_after(double t, const PlanRequest& request, const NmpcParams& params);

/// The leader's way from where it is to where it is expected in the end, Trail::kSpacing apart or a
/// little more.
[[nodiscard]] std::vector<Eigen::Vector2d> leader_onward(const PlanRequest& request,
                                                         const NmpcParams& params);

/// How fast the speed may fall [m/s²]: comfortably, but as fast as the robot can while the stick
/// asks for far less than the command in force, or for the other way.
[[nodiscard]] double braking_of(const PlanRequest& request, const RobotParams& robot);

/// Twists and poses of the person's own wish from a place on: what the robot would do without
/// obstacles, within its limits. For a leader or goal: driving to where it will be, then turning.
struct Forecast {
  std::vector<Twist2> twist;  ///< N
  std::vector<Pose2> X_MB;    ///< N + 1
};
[[nodiscard]] Forecast forecast(const PlanRequest& request, const Moving& from,
                                const NmpcParams& params, const RobotParams& robot);

/// The same, by way of a point: an initial guess that passes an obstacle on one side.
[[nodiscard]] Forecast forecast_via(const Eigen::Vector2d& p_MV, const PlanRequest& request,
                                    const Moving& from, const NmpcParams& params,
                                    const RobotParams& robot);

/// The same toward a constant twist.
[[nodiscard]] Forecast forecast_of(const Twist2& twist, const PlanRequest& request,
                                   const Moving& from, const NmpcParams& params,
                                   const RobotParams& robot);

/// Costs of the N stages, one shape for all methods:
///
///   leader, goal  (x−x_g)ᵀQ(x−x_g) + uᵀRu, heading by 2(1 − cos), faded by 1 / (1 + (d/d₀)²)
///                 with d the distance to go and d₀ heading_fade: far away the way counts, on the
///                 spot the heading. x_g is leader_after() of the stage. goal: the last stage (1 +
///                 terminal_weight) times       (1)
///   intention     rollout: C_v(v_u−v)² + C_v(ω_u−ω)² + C_h 2(1 − cos(θ_u−θ)) + C_p|p_u−p|²
///                 + C_c|Δu−Δu_u|², with X_u and Δu_u from the forecast (v_u, ω_u reached at the
///                 acceleration limits): where nothing blocks, the forecast is the optimum    (2)
///                 atan: C_v(v_u−v)² + C_h 2(1 − cos(atan(ω_u/v_u) − atan(ω/v))) + C_c|Δu|²   (3)
///                 both fade over the horizon, as what the person wants now is known best
///   path          (1) toward the point of the trail beside which the forecast, which drives along
///                 the trail, is at that stage, a little ahead of it, with Q = R diag(along,
///                 across) Rᵀ in the frame R of the trail there: contouring and lag error (Lam,
///                 Manzie and Good 2010; Liniger, Domahidi and Morari 2015). Where the trail was
///                 cut by an obstacle no place is asked for, only the trail beyond           (4)
[[nodiscard]] std::vector<StageCost> stage_costs(const PlanRequest& request, const Forecast& wish,
                                                 const NmpcParams& params,
                                                 const RobotParams& robot);

/// Bound on what a metre of motion at X_MB can save [1/m]: Σ |∂cost/∂p| + |∂cost/∂v| / N Δt. A
/// penalty on a metre of slack is exact above the multipliers of its rows, which this pull bounds
/// as long as all stages hang on one row by a lever of about one.
[[nodiscard]] double pull(const std::vector<StageCost>& costs, const Pose2& X_MB, double dt);

}  // namespace tandem
