// SPDX-License-Identifier: Apache-2.0
// Decides when a plan begins to pass somebody who stands in the way.
#pragma once

#include <vector>

#include "tandem/local_planner/motion_check.hpp"
#include "tandem/local_planner/nmpc_params.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// The obstacles that a plan for the request must avoid. With kIntention and a straight stick,
/// leaves out each tracked obstacle that stands, while its distance from the robot [m] is more than
///
///   margin + v (delay + 0.5 s) + v² / (2 a_max),
///
/// with v [m/s] the greater of the speed in force and the measured one: braking half a second later
/// is still early enough. The person at the stick mostly means to stop before somebody who stands;
/// over the whole horizon going round costs less than stopping, so a plan would swerve at once.
[[nodiscard]] std::vector<Obstacle> obstacles_of_the_plan(const PlanRequest& request,
                                                          const Body& body,
                                                          const NmpcParams& params,
                                                          const RobotParams& robot);

}  // namespace tandem
