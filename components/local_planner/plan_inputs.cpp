// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/plan_inputs.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/model/brief_push.hpp"

namespace tandem {
namespace {

// Points of a given path that are planned for: farther than the horizon reaches, and short enough
// that the end of a closed path is not taken for its beginning.
constexpr std::size_t kPathAhead = 80;

}  // namespace

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

void PlanInputs::on_path(std::span<const Pose2> path) {
  std::vector<Eigen::Vector2d> points;
  for (const Pose2& X_MP : path) points.push_back(X_MP.position());
  path_.follow(points);
  X_ME_ = path.back();
}

void PlanInputs::drop_goals() {
  X_MG_.reset();
  X_ME_.reset();
  path_.clear();
}

std::optional<Reason> PlanInputs::missing(Method method, double now) const {
  const auto unless = [](bool there, Reason reason) {
    return there ? std::nullopt : std::optional{reason};
  };
  if (!obstacles_.fresh(now, params_.obstacle_timeout)) return Reason::kObstaclesSilent;
  switch (method) {
    case Method::kPath:
      if (X_ME_) return std::nullopt;
      [[fallthrough]];
    case Method::kLeader:
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
    request.rests = asks_to_stop(user_.value, robot.twist);
  }
  request.obstacles = obstacles_.value;
  request.guidance = guidance_;
  if (filter_.fresh(now, params_.in_force_timeout)) {
    request.guarded = filter_.value.enforces;
    request.refused = filter_.value.refuses;
  }
  if (method == Method::kPath && X_ME_) ask_for_path(request);
  return request;
}

// The person does not steer along a given path.
void PlanInputs::ask_for_path(PlanRequest& request) const {
  request.user = {};
  request.rests = false;
  const auto& points = path_.points();
  request.path = std::span{points}.first(std::min(points.size(), kPathAhead));
  request.X_MG = *X_ME_;
  if (points.size() <= kPathAhead) return;
  const Eigen::Vector2d to = points[kPathAhead - 1], along = to - points[kPathAhead - 2];
  request.X_MG = {to.x(), to.y(), std::atan2(along.y(), along.x())};
}

}  // namespace tandem
