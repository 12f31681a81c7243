// SPDX-License-Identifier: Apache-2.0
// The planner's request and its answer, a motion over the horizon.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "tandem/local_planner/solvers/solver_types.hpp"
#include "tandem/model/guidance_line.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// What the cost's reference is derived from.
enum class Method {
  kLeader,     ///< Devalla 2020, 3.24 and 3.40: follow the virtual robot X_MG
  kIntention,  ///< Krijnen 2020, 2.3: follow the person's twist, without estimating a goal
  kPath,       ///< Devalla 2020, 5.1: follow the trail of the virtual robot X_MG, or a given path
  kGoal,       ///< Devalla 2020, 3.24: a fixed pose X_MG, with a terminal cost
};

/// Input of one planning cycle, all in the map frame M.
struct PlanRequest {
  Method method = Method::kLeader;              ///< what to follow
  double t = 0.0;                               ///< time of X_MB and of the call [s]
  Pose2 X_MB = {};                              ///< measured
  Twist2 command = {};                          ///< in force: the last one sent
  Twist2 measured = {};                         ///< twist from odometry
  Pose2 X_MG = {};                              ///< leader or goal; not read by kIntention
  std::span<const Eigen::Vector2d> path = {};   ///< kPath: to be followed instead, as far as X_MG
  std::span<const Eigen::Vector2d> trail = {};  ///< kPath: filled in by Nmpc, see trail.hpp
  Twist2 user = {};                             ///< the person's twist; not read by kGoal
  bool rests = false;                           ///< `user` was received and asks_to_stop()
  std::span<const Obstacle> obstacles = {};     ///< positions and velocities at time t
  std::span<const GuidanceLine> guidance = {};  ///< see guided()
  bool guarded = false;                         ///< a safety filter reports that it enforces
  bool refused = false;  ///< the filter passes nothing of the plans because of near obstacles
};

/// How planning ended. Negative: the twists are a fallback, not a new solution.
enum class PlanStatus : int {
  kOptimal = 0,      ///< solver converged, exact check passed
  kAcceptable = 1,   ///< not converged, but the motion passed the exact check and is the best known
  kTimeout = -1,     ///< budget or iterations exhausted without a usable motion
  kInfeasible = -2,  ///< solved, but the motion fails the exact check
  kRefused = -3,     ///< the request is not finite, or an input is silent and there is no request
};

/// Origin of a plan's twists.
enum class PlanSource {
  kSolution,  ///< this cycle's solution
  kPrevious,  ///< rest of the last good plan, checked again
  kBraking,   ///< braking to rest along the current arc
  kYielded,   ///< the person's own twist, unchecked: see close_approach.hpp and deadlock.hpp
  kResting,   ///< braking as hard as the robot can because the stick is at rest
  kStanding,  ///< zero: the robot is at rest already, or an input is missing
};

/// The method as parameters and messages write it.
[[nodiscard]] const char* name(Method method);
/// The status in short, for logs and tables.
[[nodiscard]] const char* name(PlanStatus status);
/// The source in short, for logs and tables.
[[nodiscard]] const char* name(PlanSource source);

/// Whether the twists replace a solution that was not found: kPrevious, kBraking or kStanding.
[[nodiscard]] bool is_fallback(PlanSource source);

/// Throws std::invalid_argument unless `text` is the name of a method.
[[nodiscard]] Method method_named(std::string_view text);

/// Share of each term of the objective; their sum is the cost.
struct CostParts {
  double pose = 0.0;    ///< position and heading
  double twist = 0.0;   ///< speed, turn rate and their direction
  double change = 0.0;  ///< change of the twist from stage to stage
  double slack = 0.0;   ///< penalty on margin violations
};

/// Motion from t0 on in the map frame: N twists, each held for dt, along N + 1 poses.
struct Plan {
  PlanStatus status = PlanStatus::kRefused;  ///< how planning ended
  PlanSource source = PlanSource::kBraking;  ///< whose twists these are
  SolverKind solver = SolverKind::kIpopt;    ///< that found the solution, for kSolution
  Verdict verdict = Verdict::kUnverified;    ///< the verifier's, for kSolution
  Twist2 command = {};                       ///< to send now, reachable from the command in force
  double t0 = 0.0;                 ///< when the command acts: the request's t plus the delay [s]
  double dt = 0.25;                ///< [s]
  std::vector<Pose2> X_MB = {};    ///< N + 1 poses [m, rad], headings continuous
  std::vector<Twist2> twist = {};  ///< N twists; the first is `command` except for kResting
  double cost = 0.0;               ///< objective of the solution, 0 for a fallback
  CostParts parts = {};            ///< cost by terms
  int active = 0;                  ///< (disc, obstacle) rows that hold with equality
  double slack = 0.0;              ///< largest violation of the margin over the horizon [m]
  double clearance = 0.0;          ///< smallest gap of the discs to any obstacle at the nodes [m]
  double solve_time = 0.0;         ///< wall clock of the whole cycle [s]
  int iterations = 0;              ///< of all solves of the cycle
  int guesses = 0;                 ///< initial guesses considered, including the last plan
  int solves = 0;                  ///< up to two per guess, plus the verifier's
  int confirmed = 0;               ///< solves that the verifier confirmed
  int disagreements = 0;  ///< solves on which the solvers disagree or the structured one failed

  /// Twist in force at time t [s] on the request's clock: zero after the end, the first before t0.
  [[nodiscard]] Twist2 at(double t) const;
  /// Pose at time t [s]: the last one after the end.
  [[nodiscard]] Pose2 pose_at(double t) const;
};

}  // namespace tandem
