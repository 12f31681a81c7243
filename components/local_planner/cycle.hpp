// SPDX-License-Identifier: Apache-2.0
// One planning cycle's data, and the functions that state its problem and rate its solutions.
#pragma once

#include <vector>

#include "tandem/local_planner/fallback.hpp"
#include "tandem/local_planner/nmpc_params.hpp"
#include "tandem/local_planner/ocp/pairs.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/local_planner/reference.hpp"
#include "tandem/local_planner/solvers/solver.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// The robot of the parameters: discs for the optimal control problem, outline for the check.
[[nodiscard]] Body body_of(const NmpcParams& params, const RobotParams& robot);

/// Whether all numbers that the request's method reads are finite and all obstacles have an extent.
[[nodiscard]] bool is_valid(const PlanRequest& request);

/// One planning cycle: the request and everything derived from it before the first solve. Refers to
/// the arguments of begin_cycle and must not outlive them.
struct Cycle {
  const NmpcParams& params;
  const RobotParams& robot;
  const Body& body;
  const PlanRequest& request;
  Start start;                     ///< predicted for the moment the command acts
  Forecast nominal;                ///< nominal trajectory: what the person asks for
  Ocp base;                        ///< the problem without pairs
  std::vector<Obstacle> to_avoid;  ///< the request's obstacles, see passable()
  PairLimits limits;
  double least_slack;  ///< by how much the start pose already violates the margin [m]
};
/// A command and the interval during which it was in force [s].
struct Sent {
  Twist2 twist;
  double from = 0.0, until = 0.0;
};

/// `sent`: the known commands of the last `delay` seconds, oldest first. Their effect is not yet
/// visible in the measured pose; delay compensation applies them to it.
[[nodiscard]] Cycle begin_cycle(const PlanRequest& request, const NmpcParams& params,
                                const RobotParams& robot, const Body& body,
                                std::span<const Sent> sent = {});

/// The optimal control problem with the nearest pairs along the guess. Feasible for any command in
/// force.
[[nodiscard]] Ocp problem(const Cycle& cycle, const Forecast& guess);

/// The motion a solve ended with, and its rating.
struct Candidate {
  Solution solution = {};
  SolverKind solver = SolverKind::kIpopt;  ///< that found the solution
  Verdict verdict = Verdict::kUnverified;  ///< the verifier's, on the solution
  Ocp ocp = {};
  Forecast motion = {};           ///< within all limits, along the model
  std::vector<double> gaps = {};  ///< N, see clearances()
  double cost = 0.0;              ///< objective of the motion, all pairs counted
  double value = 0.0;             ///< cost, plus an estimate of the cost beyond the horizon
  double slack = 0.0;             ///< largest violation of the margin [m]
  double clearance = 0.0;         ///< smallest gap of any disc at the nodes [m]
};

/// Clamps the motion's twists to the problem's limits and rolls them out with its model.
[[nodiscard]] Forecast within_limits(const Ocp& ocp, const Forecast& motion);

/// Brings the motion within all limits and computes its cost, slack and clearance. The pairs of
/// `ocp` are not read.
[[nodiscard]] Candidate rate(const Cycle& cycle, Ocp ocp, const Forecast& motion);

/// Whether the motion passes the exact check for as long as the robot needs to come to rest.
[[nodiscard]] bool is_clear(const Cycle& cycle, const Candidate& candidate);

/// The motion's cost by terms of the objective.
[[nodiscard]] CostParts cost_parts(const Candidate& candidate);

/// Number of rows (4) of ocp.hpp that are active along the motion.
[[nodiscard]] int active_rows(const Candidate& candidate);

/// Whether the solution violates the margin of a pair that its problem left out.
[[nodiscard]] bool left_out_a_pair(const Candidate& candidate);

/// Whether the motion violates the margin by more than the start does, or makes little progress
/// near an obstacle.
[[nodiscard]] bool is_poor(const Cycle& cycle, const Candidate& candidate);

/// Initial guess without a last solution: the nominal trajectory, stopped before what blocks it.
[[nodiscard]] Forecast cold_guess(const Cycle& cycle);

/// Alternative initial guesses. If something blocks the nominal trajectory: past it on the left, on
/// the right, and to rest. Always: the nominal trajectory and `arcs` constant twists, taken in turn
/// from a fixed list starting at index `turn`. Each is stopped before what blocks it.
[[nodiscard]] std::vector<Forecast> other_guesses(const Cycle& cycle, unsigned turn, unsigned arcs);

/// Sorts the guesses by their value before any solve, so that a limited budget goes to the best.
/// Rating a motion takes a fraction of the time of a solve.
[[nodiscard]] std::vector<Forecast> most_promising_first(const Cycle& cycle,
                                                         std::vector<Forecast> guesses);

}  // namespace tandem
