// SPDX-License-Identifier: Apache-2.0
// In: one request. Out: what a planning cycle needs to state, start and judge its solves.
#pragma once

#include <vector>

#include "local_planner/fallback.hpp"
#include "local_planner/nmpc_params.hpp"
#include "local_planner/pairs.hpp"
#include "local_planner/plan.hpp"
#include "local_planner/reference.hpp"
#include "local_planner/solver.hpp"
#include "model/robot.hpp"

namespace tandem {

/// The robot of the parameters: discs for the programme, outline for the check.
[[nodiscard]] Body body_of(const NmpcParams& params, const RobotParams& robot);

/// Whether a request holds nothing but finite numbers, and ellipses with an extent.
[[nodiscard]] bool is_valid(const PlanRequest& request);

/// One planning cycle: the request and what follows from it before any solve. Refers to the
/// arguments of begin_cycle and must not outlive them.
struct Cycle {
  const NmpcParams& params;
  const RobotParams& robot;
  const Body& body;
  const PlanRequest& request;
  Start start;                     ///< predicted for the moment the command acts
  Forecast wish;                   ///< what the person asks for
  std::vector<StageCost> costs;    ///< N
  std::vector<Obstacle> to_avoid;  ///< the request's obstacles, see passable()
  PairLimits limits;
  double least_slack;  ///< the margin is missed this much at the start already [m]
};
[[nodiscard]] Cycle begin_cycle(const PlanRequest& request, const NmpcParams& params,
                                const RobotParams& robot, const Body& body);

/// The problem with the pairs that matter along the guess. Feasible for any command in force.
[[nodiscard]] Ocp problem(const Cycle& cycle, const Forecast& guess);

/// A motion that a solve ended with, and what it is worth.
struct Candidate {
  Solution solution = {};
  SolverKind solver = SolverKind::kIpopt;  ///< whose solution
  Ocp ocp = {};
  Forecast motion = {};    ///< within all limits, along the model
  double cost = 0.0;       ///< objective of the motion, all pairs counted
  double slack = 0.0;      ///< largest miss of the margin [m]
  double clearance = 0.0;  ///< smallest gap of any disc at the nodes [m]
  bool clear = false;      ///< passed the exact check as far as it matters for braking
};

/// The motion's twists brought within all limits, rolled out along the model, and judged.
[[nodiscard]] Candidate rate(const Cycle& cycle, Ocp ocp, const Forecast& motion);

/// Whether the solution went where a pair matters that its problem left out.
[[nodiscard]] bool left_out_a_pair(const Cycle& cycle, const Candidate& candidate);

/// A motion that fails the check, misses the margin more than the start does, or goes nowhere.
[[nodiscard]] bool is_poor(const Cycle& cycle, const Candidate& candidate);

/// Initial guess without a last solution: the wish, stopped short of whatever blocks it.
[[nodiscard]] Forecast cold_guess(const Cycle& cycle);

/// Where else to start from: past the blocker left, past it right, short of it.
[[nodiscard]] std::vector<Forecast> other_guesses(const Cycle& cycle);

}  // namespace tandem
