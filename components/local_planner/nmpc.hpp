// SPDX-License-Identifier: Apache-2.0
// In: a request every control period. Out: a plan that was checked, or a fallback that says so.
#pragma once

#include <memory>

#include "tandem/local_planner/nmpc_params.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// Receding-horizon planner; the optimal control problem is stated in ocp.hpp.
///
/// Where Ipopt has to solve with MUMPS, one solve runs at a time per process; else none waits for
/// another. With time_budget = 0 equal sequences of requests give equal plans, bit for bit.
class Nmpc {
 public:
  /// Throws std::invalid_argument on parameters out of range or that contradict each other.
  Nmpc(const NmpcParams& params, const RobotParams& robot);
  ~Nmpc();
  Nmpc(Nmpc&&) noexcept;
  Nmpc& operator=(Nmpc&&) noexcept;

  /// Goes on with other parameters: the next solve starts cold, but the way driven, the commands
  /// sent and the last good plan are kept. Throws as the constructor, having changed nothing.
  void set_params(const NmpcParams& params);

  /// Plans from the pose predicted for the moment the command acts. Does not throw.
  [[nodiscard]] Plan solve(const PlanRequest& request);

  /// Forgets the last plan: the next solve starts cold.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
