// SPDX-License-Identifier: Apache-2.0
// The planner: turns one request per control period into a checked plan or a fallback.
#pragma once

#include <memory>

#include "tandem/local_planner/nmpc_params.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// Receding-horizon planner; the optimal control problem is stated in ocp.hpp.
///
/// If Ipopt uses MUMPS, which is not thread-safe, Ipopt's solves in one process run one at a time;
/// otherwise instances do not block each other. With time_budget = 0 equal sequences of requests
/// give bitwise equal plans.
class Nmpc {
 public:
  /// Throws std::invalid_argument on parameters that are out of range or contradict each other.
  Nmpc(const NmpcParams& params, const RobotParams& robot);
  ~Nmpc();
  Nmpc(Nmpc&&) noexcept;
  Nmpc& operator=(Nmpc&&) noexcept;

  /// Replaces the parameters. The next solve starts cold; the leader's trail, the commands sent,
  /// the measured delay and the last good plan are kept. Throws as the constructor does, in which
  /// case nothing has changed.
  void set_params(const NmpcParams& params);

  /// Plans from the pose predicted for the moment the command acts. Does not throw.
  [[nodiscard]] Plan solve(const PlanRequest& request);

  /// Discards the last plan, the commands sent and the leader's trail: the next solve starts cold.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
