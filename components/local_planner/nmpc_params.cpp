// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/nmpc_params.hpp"

namespace tandem {

NmpcParams script_exact(bool with_obstacles) {
  NmpcParams params;
  params.horizon_steps = 15;
  params.dt = params.control_period = 0.25;
  params.delay = 0.0;
  params.time_budget = 0.0;
  params.extra_guesses = 0;
  params.model = "euler";
  params.weight_x = params.weight_y = with_obstacles ? 6.0 : 3.0;
  params.weight_heading = with_obstacles ? 4.0 : 1.5;
  params.weight_v = with_obstacles ? 0.3 : 0.7;
  params.weight_w = with_obstacles ? 0.15 : 0.3;
  params.weight_smooth = 0.0;
  params.terminal_weight = 0.0;
  params.heading_fade = 0.0;
  params.margin = params.margin_moving = params.margin_v = params.margin_w = 0.0;
  params.disc_radius = 0.45;
  params.workspace = 4.2;
  return params;
}

}  // namespace tandem
