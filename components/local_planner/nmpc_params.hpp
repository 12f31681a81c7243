// SPDX-License-Identifier: Apache-2.0
// Parameters of the NMPC: horizon, weights, margins and budgets.
#pragma once

#include <string>

#include "tandem/config/params.hpp"
#include "tandem/model/motor_lag.hpp"

namespace tandem {

/// Tuning of the NMPC. Speed and acceleration limits come from RobotParams.
///
/// Symbols of ocp.hpp: horizon_steps = N, dt = Δt, weight_* = Q, R, C. script_exact() reproduces
/// scripts B.1 and B.2 of Devalla 2020.
struct NmpcParams {
  int horizon_steps = 15;
  double dt = 0.25;
  double control_period = 0.05;
  double delay = 0.09;
  bool measure_delay = false;
  double lag_v = 0.0, lag_w = 0.0;
  double time_budget = 0.035;
  int max_iterations = 60;
  int iteration_budget = 0;
  int extra_guesses = 1;
  std::string solver = "certified";
  std::string model = "arc";

  double weight_x = 6.0, weight_y = 6.0, weight_heading = 4.0;
  double weight_v = 0.3, weight_w = 0.15;
  double weight_smooth = 0.1;
  // Equal because across : along of 12 : 4 and 6 : 3 is slower in the corridor, and 6 : 9
  // and 6 : 12 are no faster over more seeds.
  double weight_across = 6.0, weight_along = 6.0;
  double terminal_weight = 50.0;
  double heading_fade = 0.5;
  double leader_preview = 0.4;

  std::string intention_form = "rollout";
  double intention_speed = 0.8;
  double intention_heading = 0.25;
  double intention_smooth = 0.1;
  double intention_position = 0.4;

  double margin = 0.04;
  double margin_v = 0.18;
  double margin_w = 0.02;
  // Among people the robot stands more with 0.35 and 0.5, and arrives later with 0.7 and 1.
  double margin_moving = 0.6;
  double disc_overhang = 0.014;
  double disc_radius = 0.0;
  int max_pairs = 6;
  double workspace = 0.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("horizon_steps", horizon_steps, Range{2, 100}, "number of steps planned ahead");
    field("dt", dt, Range{0.02, 1.0}, "[s] duration of a step");
    field("control_period", control_period, Range{0.005, 1.0}, "[s] time between two commands");
    field("delay", delay, Range{0.0, 1.0},
          "[s] from the measured pose to the command's effect, including motor lag unless lag_v "
          "and lag_w model it");
    field("measure_delay", measure_delay,
          "true: estimate the delay from commands and odometry while the robot drives, instead of "
          "using `delay`");
    field("lag_v", lag_v, Range{0.0, 2.0},
          "[s] time constant of the speed, for robots that do not follow at once; 0: part of the "
          "delay");
    field("lag_w", lag_w, Range{0.0, 2.0},
          "[s] time constant of the turn rate; 0: part of the delay");
    field("time_budget", time_budget, Range{0.0, 1.0},
          "[s] wall-clock limit of one planning cycle; 0: unlimited, and the result is "
          "deterministic");
    field("max_iterations", max_iterations, Range{1, 1000}, "maximum iterations of one solve");
    field("iteration_budget", iteration_budget, Range{0, 100000},
          "maximum iterations of one planning cycle, a deterministic substitute for time_budget; "
          "0: no limit");
    field("extra_guesses", extra_guesses, Range{0, 10},
          "number of sampled arcs that a cycle starts from, besides the last plan, passages left "
          "and right of what blocks the path, the nominal trajectory and standing still; three "
          "times as many if none leads anywhere; 0: only the last plan");
    field("solver", solver, OneOf{{"ipopt", "structured", "certified"}},
          "structured: Riccati interior point, far faster than ipopt; certified: structured, with "
          "its optimality checked, and ipopt where that fails");
    field("model", model, OneOf{{"arc", "euler"}},
          "discretization of the motion: exact arc, or Euler step");
    field("weight_x", weight_x, Range{0.0, 1e4},
          "leader, goal: weight of the position error along the map's x");
    field("weight_y", weight_y, Range{0.0, 1e4},
          "leader, goal: weight of the position error along the map's y");
    field("weight_heading", weight_heading, Range{0.0, 1e4},
          "leader, goal, path: weight of the heading error");
    field("weight_v", weight_v, Range{0.0, 1e4}, "leader, goal, path: weight of the speed");
    field("weight_w", weight_w, Range{0.0, 1e4}, "leader, goal, path: weight of the turn rate");
    field("weight_smooth", weight_smooth, Range{0.0, 1e4},
          "leader, goal, path: weight of the change of speed and turn rate from step to step");
    field("weight_across", weight_across, Range{0.0, 1e4},
          "[1/m²] path: weight of the error across the trail (contouring error)");
    field("weight_along", weight_along, Range{0.0, 1e4},
          "[1/m²] path: weight of the error along the trail (lag error); below "
          "weight_across the robot prefers being late to cutting corners");
    field("terminal_weight", terminal_weight, Range{0.0, 1e4},
          "goal: factor by which the last pose counts more");
    field("heading_fade", heading_fade, Range{0.0, 10.0},
          "[m] leader, goal, path: distance at which the heading counts half; 0: always fully");
    field("leader_preview", leader_preview, Range{0.0, 10.0},
          "[s] leader, path: the leader is predicted to keep its current motion for this long; 0: "
          "to stay where it is");
    field("intention_form", intention_form, OneOf{{"rollout", "atan"}},
          "intended heading: from the predicted motion of the person's twist, or Krijnen's "
          "atan(w/v)");
    field("intention_speed", intention_speed, Range{0.0, 1e4},
          "C_v: weight of the deviation of speed");
    field("intention_heading", intention_heading, Range{0.0, 1e4},
          "C_h: weight of the deviation of heading");
    field("intention_smooth", intention_smooth, Range{0.0, 1e4},
          "C_c: weight of changes of speed and turn rate beyond the person's own");
    field("intention_position", intention_position, Range{0.0, 1e4},
          "rollout form: weight of the distance from the predicted path");
    field("margin", margin, Range{0.0, 1.0}, "[m] distance kept between the discs and obstacles");
    field("margin_moving", margin_moving, Range{0.0, 2.0},
          "[m] added to the margin for moving obstacles");
    field("margin_v", margin_v, Range{0.0, 2.0}, "[s²/m] the margin grows by this times v²");
    field("margin_w", margin_w, Range{0.0, 2.0}, "[m s²/rad²] the margin grows by this times w²");
    field("disc_overhang", disc_overhang, Range{0.002, 1.0},
          "[m] how far the discs that cover the footprint may extend beyond its sides; smaller "
          "values "
          "need more discs");
    field("disc_radius", disc_radius, Range{0.0, 3.0},
          "[m] radius of a single disc about base_link used instead of the footprint for planning "
          "and checking; 0: use the footprint");
    field("max_pairs", max_pairs, Range{1, 32},
          "number of nearest (disc, obstacle) pairs kept per step");
    field("workspace", workspace, Range{0.0, 1e4},
          "[m] bound on |x| and |y| of base_link; 0: none");
  }
};

/// The motors' lag that the prediction assumes.
[[nodiscard]] inline MotorLag lag_of(const NmpcParams& params) {
  return {params.lag_v, params.lag_w};
}

/// Parameters of Devalla's scripts: Euler, N = 15, Δt = control period = 0.25 s, circle of radius
/// 0.45 m, workspace ±4.2 m, no terminal cost, no delay. Weights without obstacles (B.1) or with
/// the sixteen poles (B.2).
[[nodiscard]] NmpcParams script_exact(bool with_obstacles);

}  // namespace tandem
