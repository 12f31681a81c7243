// SPDX-License-Identifier: Apache-2.0
// Builds the requests that the planner's tests share.
#pragma once

#include <cstdlib>

#include "tandem/local_planner/nmpc.hpp"

namespace tandem::test {

/// The planner's parameters, with the solver that the environment selects.
inline NmpcParams default_params() {
  NmpcParams params;
  if (const char* solver = std::getenv("TANDEM_TEST_SOLVER")) params.solver = solver;
  return params;
}

inline NmpcParams unlimited() {
  NmpcParams params = default_params();
  params.time_budget = 0.0;
  return params;
}

inline PlanRequest goal_request(const Pose2& X_MG) {
  return {.method = Method::kGoal, .X_MB = {0, 0, 0}, .X_MG = X_MG};
}

inline Obstacle pole(double x, double y) { return {7, {x, y}, 0.225, 0.225, 0.0, {0, 0}}; }

inline Plan solve_once(const PlanRequest& request, const NmpcParams& params = unlimited()) {
  return Nmpc(params, RobotParams{}).solve(request);
}

}  // namespace tandem::test
