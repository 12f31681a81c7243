// SPDX-License-Identifier: Apache-2.0
// In: one request. Out: what a planning cycle needs to state, start and judge its solves.
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
/// A command and the time in which it was in force [s].
struct Sent {
  Twist2 twist;
  double from = 0.0, until = 0.0;
};

/// `sent`: the commands of the last `delay` seconds, oldest first, as far as they are known. They
/// are still to be seen in the measured pose, and are what the delay is compensated by.
[[nodiscard]] Cycle begin_cycle(const PlanRequest& request, const NmpcParams& params,
                                const RobotParams& robot, const Body& body,
                                std::span<const Sent> sent = {});

/// The problem with the pairs that matter along the guess. Feasible for any command in force.
[[nodiscard]] Ocp problem(const Cycle& cycle, const Forecast& guess);

/// A motion that a solve ended with, and what it is worth.
struct Candidate {
  Solution solution = {};
  SolverKind solver = SolverKind::kIpopt;  ///< whose solution
  Verdict verdict = Verdict::kUnjudged;    ///< of the second solver on it
  Ocp ocp = {};
  Forecast motion = {};           ///< within all limits, along the model
  std::vector<double> gaps = {};  ///< N, see clearances()
  double cost = 0.0;              ///< objective of the motion, all pairs counted
  double value = 0.0;             ///< cost, and what is still to come where the horizon ends
  double slack = 0.0;             ///< largest miss of the margin [m]
  double clearance = 0.0;         ///< smallest gap of any disc at the nodes [m]
};

/// The motion's twists brought within all limits of the problem and rolled out along its model.
[[nodiscard]] Forecast within_limits(const Ocp& ocp, const Forecast& motion);

/// The motion within all limits, and its cost.
[[nodiscard]] Candidate rate(const Cycle& cycle, Ocp ocp, const Forecast& motion);

/// Whether the exact check passes as far as it matters for braking.
[[nodiscard]] bool is_clear(const Cycle& cycle, const Candidate& candidate);

/// What the objective of the motion is made of.
[[nodiscard]] CostParts cost_parts(const Candidate& candidate);

/// Rows (4) of ocp.hpp that bind the motion.
[[nodiscard]] int active_rows(const Candidate& candidate);

/// Whether the solution went where a pair matters that its problem left out.
[[nodiscard]] bool left_out_a_pair(const Candidate& candidate);

/// A motion that misses the margin more than the start does, or goes nowhere.
[[nodiscard]] bool is_poor(const Cycle& cycle, const Candidate& candidate);

/// Initial guess without a last solution: the wish, stopped short of whatever blocks it.
[[nodiscard]] Forecast cold_guess(const Cycle& cycle);

/// Where else to start from: if something blocks the wish, past it on its left, on its right, to
/// rest; the wish itself as far as it goes, and then `arcs` of a few constant twists, in turns from
/// `turn` on.
[[nodiscard]] std::vector<Forecast> other_guesses(const Cycle& cycle, unsigned turn, unsigned arcs);

/// By what the guesses are worth as they are, so that a budget too short for all solves the best:
/// rating a motion costs a fraction of a solve that starts from it.
[[nodiscard]] std::vector<Forecast> most_promising_first(const Cycle& cycle,
                                                         std::vector<Forecast> guesses);

}  // namespace tandem
