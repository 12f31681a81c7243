// SPDX-License-Identifier: Apache-2.0
// In: where the robot is, what the person wants, what stands around. Out: motion over the horizon.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "tandem/local_planner/solvers/solver_types.hpp"
#include "tandem/model/guidance_line.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Where the reference of the cost comes from.
enum class Method {
  kLeader,     ///< Devalla 2020, 3.24 and 3.40: chase the virtual robot X_MG
  kIntention,  ///< Krijnen 2020, 2.3: do what the person's twist asks for, no goal guessed
  kPath,       ///< Devalla 2020, 5.1: follow the trail of the virtual robot X_MG
  kGoal,       ///< Devalla 2020, 3.24: a fixed pose X_MG, with a terminal cost
};

/// One planning cycle's input, all in the map frame M.
struct PlanRequest {
  Method method = Method::kLeader;
  double t = 0.0;                               ///< time of X_MB, and of the call [s]
  Pose2 X_MB = {};                              ///< measured
  Twist2 command = {};                          ///< in force: the last one that was sent
  Twist2 measured = {};                         ///< twist from odometry
  Pose2 X_MG = {};                              ///< leader or goal; not read by kIntention
  std::span<const Eigen::Vector2d> trail = {};  ///< kPath: the leader's way, see trail.hpp
  Twist2 user = {};                             ///< the person's twist; not read by kGoal
  bool rests = false;  ///< the person holds the stick at rest: `user` is zero, and known to be
  std::span<const Obstacle> obstacles = {};     ///< places and velocities at time t
  std::span<const GuidanceLine> guidance = {};  ///< see guided()
  bool guarded = false;                         ///< a safety filter enforces what passes
  bool refused = false;  ///< … and lets nothing of the plans pass, for what is near
};

/// How planning ended. Negative: the twists are a fallback, not a new solution.
enum class PlanStatus : int {
  kOptimal = 0,      ///< solver converged, exact check passed
  kAcceptable = 1,   ///< not converged, but the motion was checked and is the best known
  kTimeout = -1,     ///< budget or iterations ran out without a usable motion
  kInfeasible = -2,  ///< solved, but the motion fails the exact check
  kRefused = -3,     ///< the request is not finite, or there is none: an input is silent
};

/// What the twists of a plan are.
enum class PlanSource {
  kSolution,  ///< of this cycle
  kPrevious,  ///< rest of the last good plan, checked again
  kBraking,   ///< slowing to rest along the current arc
  kYielded,   ///< the person's own twist, unchecked: see close_approach.hpp and deadlock.hpp
  kResting,   ///< braking as hard as the robot can, as the stick at rest asks for
  kStanding,  ///< zero and nothing else: at rest, or nothing is known to plan from
};

[[nodiscard]] const char* name(Method method);
[[nodiscard]] const char* name(PlanStatus status);
[[nodiscard]] const char* name(PlanSource source);

/// Whether the twists stand in for a solution that was not to be had.
[[nodiscard]] bool is_fallback(PlanSource source);

/// Throws std::invalid_argument unless `text` is the name of a method.
[[nodiscard]] Method method_named(std::string_view text);

/// Share of each term of the objective; their sum is the cost.
struct CostParts {
  double pose = 0.0;    ///< position and heading
  double twist = 0.0;   ///< speed, turn rate and their direction
  double change = 0.0;  ///< of the twist from stage to stage
  double slack = 0.0;   ///< penalty
};

/// Motion from t0 on: N twists, each held for dt, along N + 1 poses.
struct Plan {
  PlanStatus status = PlanStatus::kRefused;
  PlanSource source = PlanSource::kBraking;
  SolverKind solver = SolverKind::kIpopt;  ///< whose solution it is, if it is one
  Verdict verdict = Verdict::kUnjudged;    ///< of the second solver on it
  Twist2 command = {};                     ///< to send now: within reach of the command in force
  double t0 = 0.0;                 ///< when the command acts: request's t plus the delay [s]
  double dt = 0.25;                ///< [s]
  std::vector<Pose2> X_MB = {};    ///< N + 1 poses [m, rad], headings continuous
  std::vector<Twist2> twist = {};  ///< N twists; the first is `command` unless braking is finer
  double cost = 0.0;               ///< objective of the solution, 0 for a fallback
  CostParts parts = {};            ///< … by its terms
  int active = 0;                  ///< rows of disc and obstacle that hold with equality
  double slack = 0.0;              ///< largest miss of the margin over the horizon [m]
  double clearance = 0.0;          ///< smallest gap of the discs to any obstacle at the nodes [m]
  double solve_time = 0.0;         ///< wall clock of the whole cycle [s]
  int iterations = 0;              ///< of all solves of the cycle
  int guesses = 0;                 ///< that were weighed, the last plan among them
  int solves = 0;                  ///< a guess may take two; the judge's is one more
  int confirmed = 0;               ///< solves that two solvers agree on
  int disagreements = 0;           ///< … do not agree on, or the structured one failed

  /// Twist in force at time t on the request's clock: zero past the end, the first before t0.
  [[nodiscard]] Twist2 at(double t) const;
  /// Pose at time t: beyond the end the last one.
  [[nodiscard]] Pose2 pose_at(double t) const;
};

}  // namespace tandem
