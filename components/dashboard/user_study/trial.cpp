// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/user_study/trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tandem/config/json_text.hpp"

namespace tandem {
namespace {

using nlohmann::json;

RegionGoal region_from(const json& from) {
  const auto corners = from.get<std::array<double, 4>>();
  for (const double x : corners)
    if (!(std::abs(x) <= 1e4)) throw std::invalid_argument("region: [x0, y0, x1, y1] in m");
  const RegionGoal region{{corners[0], corners[1]}, {corners[2], corners[3]}};
  if (!(region.low.array() < region.high.array()).all())
    throw std::invalid_argument("region: needs x0 < x1 and y0 < y1");
  return region;
}

// Without a region the trial lasts the whole time, whatever distance the robot drives.
MetricsSetting setting_of(const TrialRequest& request) {
  if (request.region) return {.goal = *request.region};
  return {.goal = RoamGoal{.time = request.asked.allowed, .distance = 0.0}};
}

}  // namespace

TrialRequest parse_trial_request(std::string_view text) {
  try {
    const json from = parse_json(text);
    TrialRequest request{.id = from.at("id").get<std::int64_t>(), .asked = parse_trial_asked(from)};
    if (from.contains("region")) request.region = region_from(from["region"]);
    return request;
  } catch (const json::exception& error) {
    throw std::invalid_argument(error.what());
  }
}

Trial::Trial(const TrialRequest& request) : request_{request}, metrics_{setting_of(request)} {
  sample_.clearance = kFarClearance;
}

void Trial::on_robot(const Pose2& X_MB, double t) {
  if (over()) return;
  sample_.X_MB = X_MB;
  sample_.t = t;
  if (!first_) first_ = t;
  metrics_.add(sample_);
}

void Trial::on_clearance(double clearance) {
  if (!std::isnan(clearance)) sample_.clearance = clearance;
}

bool Trial::over() const {
  return metrics_.finished() || (first_ && elapsed() >= request_.asked.allowed);
}

UserTrial Trial::measured() const {
  UserTrial trial = request_.asked;
  if (!first_) return trial;
  DriveResult result;
  metrics_.write(result);
  trial.reached = request_.region && result.reached;
  trial.time = std::min(trial.allowed, trial.reached ? result.time_to_goal_s : elapsed());
  trial.collisions = result.collisions;
  trial.min_clearance = result.min_clearance_m;
  trial.path_length = result.path_length_m;
  return trial;
}

std::string Trial::state() const {
  json state{{"id", request_.id},
             {"time", std::min(elapsed(), request_.asked.allowed)},
             {"collisions", sample_.collisions}};
  if (over()) state["trial"] = measured();
  return state.dump();
}

}  // namespace tandem
