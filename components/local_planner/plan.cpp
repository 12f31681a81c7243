// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/plan.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "tandem/model/reasons.hpp"

namespace tandem {
namespace {

// Constant twist that leads from one pose to the other in dt [s]; with a motor lag it is the mean.
Twist2 between(const Pose2& from, const Pose2& to, double dt) {
  const double turn = to.theta - from.theta, middle = from.theta + 0.5 * turn;
  const double chord = (to.x - from.x) * std::cos(middle) + (to.y - from.y) * std::sin(middle);
  const double sinc = std::abs(turn) < 1e-6 ? 1.0 : std::sin(0.5 * turn) / (0.5 * turn);
  return {chord / (dt * sinc), turn / dt};
}

}  // namespace

const char* name(Method method) {
  switch (method) {
    case Method::kLeader:
      return "leader";
    case Method::kIntention:
      return "intention";
    case Method::kPath:
      return "path";
    case Method::kGoal:
      return "goal";
  }
  return "?";
}

const char* name(PlanStatus status) {
  switch (status) {
    case PlanStatus::kOptimal:
      return text_of(Reason::kPlanOptimal);
    case PlanStatus::kAcceptable:
      return text_of(Reason::kPlanAcceptable);
    case PlanStatus::kTimeout:
      return text_of(Reason::kPlanTimeout);
    case PlanStatus::kInfeasible:
      return text_of(Reason::kPlanInfeasible);
    case PlanStatus::kRefused:
      return text_of(Reason::kPlanRefused);
  }
  return "?";
}

const char* name(PlanSource source) {
  switch (source) {
    case PlanSource::kSolution:
      return "solution";
    case PlanSource::kPrevious:
      return "previous";
    case PlanSource::kBraking:
      return "braking";
    case PlanSource::kYielded:
      return "yielded";
    case PlanSource::kResting:
      return "resting";
    case PlanSource::kStanding:
      return "standing";
  }
  return "?";
}

bool is_fallback(PlanSource source) {
  return source == PlanSource::kPrevious || source == PlanSource::kBraking ||
         source == PlanSource::kStanding;
}

Method method_named(std::string_view text) {
  for (const Method method : {Method::kLeader, Method::kIntention, Method::kPath, Method::kGoal})
    if (text == name(method)) return method;
  throw std::invalid_argument("method = '" + std::string(text) +
                              "' is not one of {leader, intention, path, goal}");
}

Twist2 Plan::at(double t) const {
  const double step = std::floor((t - t0) / dt + 1e-9);
  if (twist.empty() || !(step < static_cast<double>(twist.size()))) return {};
  return twist[static_cast<std::size_t>(std::max(0.0, step))];
}

Pose2 Plan::pose_at(double t) const {
  if (X_MB.empty()) return {};
  const double step = std::max(0.0, std::floor((t - t0) / dt + 1e-9));
  if (!(step < static_cast<double>(twist.size()))) return X_MB.back();
  const auto k = static_cast<std::size_t>(step);
  return integrate(X_MB[k], between(X_MB[k], X_MB[k + 1], dt), std::max(0.0, t - t0 - step * dt));
}

}  // namespace tandem
