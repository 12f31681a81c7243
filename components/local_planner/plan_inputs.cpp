// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/plan_inputs.hpp"

namespace tandem {

PlanInputs::PlanInputs(const PlanInputParams& params, std::vector<GuidanceLine> guidance)
    : params_{params}, guidance_{std::move(guidance)} {
  check(params_);
}

void PlanInputs::on_time_jump() {
  obstacles_.reset();
  user_.reset();
  command_.reset();
  leader_.reset();
  filter_.reset();
}

std::optional<Reason> PlanInputs::missing(Method method, double now) const {
  const auto unless = [](bool there, Reason reason) {
    return there ? std::nullopt : std::optional{reason};
  };
  if (!obstacles_.fresh(now, params_.obstacle_timeout)) return Reason::kObstaclesSilent;
  switch (method) {
    case Method::kLeader:
    case Method::kPath:
      return unless(leader_.fresh(now, params_.user_timeout), Reason::kLeaderSilent);
    case Method::kIntention:
      return unless(user_.fresh(now, params_.user_timeout), Reason::kUserSilent);
    case Method::kGoal:
      return unless(X_MG_.has_value(), Reason::kNoGoal);
  }
  return std::nullopt;
}

PlanRequest PlanInputs::request(Method method, const RobotState& robot, double now) const {
  PlanRequest request;
  request.method = method;
  request.t = now;
  request.X_MB = robot.X_MB;
  request.measured = robot.twist;
  if (command_.fresh(now, params_.in_force_timeout)) request.command = command_.value;
  request.X_MG = method == Method::kGoal ? X_MG_.value_or(Pose2{}) : leader_.value;
  if (user_.fresh(now, params_.user_timeout)) {
    request.user = user_.value;
    request.rests = user_.value == Twist2{};
  }
  request.obstacles = obstacles_.value;
  request.guidance = guidance_;
  if (filter_.fresh(now, params_.in_force_timeout)) {
    request.guarded = filter_.value.enforces;
    request.refused = filter_.value.refuses;
  }
  return request;
}

}  // namespace tandem
