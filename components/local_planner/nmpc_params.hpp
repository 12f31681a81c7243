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
  double weight_slack = 3.0;
  double disc_overhang = 0.014;
  double disc_radius = 0.0;
  int max_pairs = 6;
  double workspace = 0.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("horizon_steps", horizon_steps, Range{2, 100}, "steps that are planned ahead");
    field("dt", dt, Range{0.02, 1.0}, "[s] length of a step");
    field("control_period", control_period, Range{0.005, 1.0}, "[s] between two commands");
    field("delay", delay, Range{0.0, 1.0},
          "[s] from the measured pose to the command's effect, motor lag included unless lag_v and "
          "lag_w tell it");
    field("measure_delay", measure_delay,
          "replace delay by what commands and odometry say of it while the robot drives");
    field("lag_v", lag_v, Range{0.0, 2.0},
          "[s] time constant of the speed, for robots that do not follow at once; 0: in the delay");
    field("lag_w", lag_w, Range{0.0, 2.0}, "[s] time constant of the turn rate; 0: in the delay");
    field("time_budget", time_budget, Range{0.0, 1.0},
          "[s] wall clock of one planning cycle; 0: unlimited, the result is deterministic");
    field("max_iterations", max_iterations, Range{1, 1000}, "iterations of one solve");
    field(
        "iteration_budget", iteration_budget, Range{0, 100000},
        "iterations of one planning cycle, a deterministic stand-in for time_budget; 0: no limit");
    field(
        "extra_guesses", extra_guesses, Range{0, 10},
        "sampled arcs a cycle starts from beside the last plan, left and right of what blocks the "
        "way, the wish and rest, thrice as many if that leads nowhere; 0: the last plan only");
    field("solver", solver, OneOf{{"ipopt", "structured", "certified"}},
          "structured: far faster than ipopt; certified: structured, confirmed by ipopt");
    field("model", model, OneOf{{"arc", "euler"}}, "discrete motion: exact arc, or Euler's step");
    field("weight_x", weight_x, Range{0.0, 1e4}, "leader, goal: position error along x of the map");
    field("weight_y", weight_y, Range{0.0, 1e4}, "leader, goal: position error along y of the map");
    field("weight_heading", weight_heading, Range{0.0, 1e4}, "leader, goal, path: heading error");
    field("weight_v", weight_v, Range{0.0, 1e4}, "leader, goal, path: speed");
    field("weight_w", weight_w, Range{0.0, 1e4}, "leader, goal, path: turn rate");
    field("weight_smooth", weight_smooth, Range{0.0, 1e4},
          "leader, goal, path: change of speed and turn rate from step to step");
    field("weight_across", weight_across, Range{0.0, 1e4},
          "[1/m²] path: error across the trail (contouring error)");
    field("weight_along", weight_along, Range{0.0, 1e4},
          "[1/m²] path: error along the trail (lag error); less of it than across lets the robot "
          "be late rather than cut corners");
    field("terminal_weight", terminal_weight, Range{0.0, 1e4},
          "goal: the last pose counts this many times more");
    field("heading_fade", heading_fade, Range{0.0, 10.0},
          "[m] leader, goal: at this distance the heading counts half; 0: it always counts");
    field(
        "leader_preview", leader_preview, Range{0.0, 10.0},
        "[s] leader, path: the leader is expected to go on this long as the person drives it now; "
        "0: to stay where it is");
    field("intention_form", intention_form, OneOf{{"rollout", "atan"}},
          "heading wish: of the forecast of the person's twist, or Krijnen's atan(w/v)");
    field("intention_speed", intention_speed, Range{0.0, 1e4}, "C_v: deviation of speed");
    field("intention_heading", intention_heading, Range{0.0, 1e4}, "C_h: deviation of heading");
    field("intention_smooth", intention_smooth, Range{0.0, 1e4},
          "C_c: change of speed and turn rate beyond the person's own");
    field("intention_position", intention_position, Range{0.0, 1e4},
          "rollout form: distance from the forecast path");
    field("margin", margin, Range{0.0, 1.0}, "[m] gap kept between the discs and obstacles");
    field("margin_moving", margin_moving, Range{0.0, 2.0},
          "[m] the gap kept from an obstacle that moves is larger by this");
    field("margin_v", margin_v, Range{0.0, 2.0}, "[s²/m] the margin grows by this times v²");
    field("margin_w", margin_w, Range{0.0, 2.0}, "[m s²/rad²] the margin grows by this times w²");
    field("weight_slack", weight_slack, Range{1.0, 1e3},
          "penalty per metre that the margin is missed, in units of the reference's pull");
    field("disc_overhang", disc_overhang, Range{0.002, 1.0},
          "[m] how far the discs that cover the footprint may reach beyond its sides; less: more");
    field("disc_radius", disc_radius, Range{0.0, 3.0},
          "[m] plan and check the robot as this one disc about base_link; 0: the footprint");
    field("max_pairs", max_pairs, Range{1, 32}, "nearest (disc, obstacle) pairs kept per step");
    field("workspace", workspace, Range{0.0, 1e4},
          "[m] |x|, |y| of base_link stay below it; 0: no bound");
  }
};

[[nodiscard]] inline MotorLag lag_of(const NmpcParams& params) {
  return {params.lag_v, params.lag_w};
}

/// Parameters of Devalla's scripts: Euler, N = 15, Δt = control period = 0.25 s, circle of radius
/// 0.45 m, workspace ±4.2 m, no terminal cost, no delay. Weights without obstacles (B.1) or with
/// the sixteen poles (B.2).
[[nodiscard]] NmpcParams script_exact(bool with_obstacles);

}  // namespace tandem
