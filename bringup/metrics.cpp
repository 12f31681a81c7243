// SPDX-License-Identifier: Apache-2.0
#include "bringup/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tandem {
namespace {

constexpr double kPushes = 0.1;       // [m/s, rad/s] the person wants to move
constexpr double kStands = 0.03;      // [m/s]
constexpr double kStandsTurn = 0.05;  // [rad/s]

double squared(double x) { return x * x; }

bool is_stuck(const DriveSample& sample) {
  const bool pushes = std::abs(sample.user.v) > kPushes || std::abs(sample.user.w) > kPushes;
  return pushes && std::abs(sample.twist.v) < kStands && std::abs(sample.twist.w) < kStandsTurn;
}

double position_error(const Goal& goal, const Eigen::Vector2d& p_MB) {
  if (const auto* region = std::get_if<RegionGoal>(&goal))
    return (0.5 * (region->low + region->high) - p_MB).norm();
  if (const auto* pose = std::get_if<PoseGoal>(&goal)) return (pose->X_MG.position() - p_MB).norm();
  return 0.0;
}

}  // namespace

Quantiles quantiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank = [&](double share) {
    const auto i = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
    return values[std::clamp<std::size_t>(i, 1, values.size()) - 1];
  };
  return {rank(0.5), rank(0.95), rank(0.99), values.back()};
}

void Metrics::add(const DriveSample& sample) {
  if (!started_) {
    started_ = true;
    start_ = sample.t;
    last_ = sample;
  }
  const double dt = sample.t - last_.t;
  path_length_ += (sample.X_MB.position() - last_.X_MB.position()).norm();
  min_clearance_ = std::min(min_clearance_, sample.clearance);
  if (is_stuck(sample)) stuck_ += dt;
  squared_difference_ += dt * 0.5 *
                         (squared((sample.user.v - sample.twist.v) / v_max_) +
                          squared((sample.user.w - sample.twist.w) / w_max_));
  observed_ += dt;
  last_ = sample;
  if (finished_ || !is_finished(sample)) return;
  finished_ = true;
  time_to_goal_ = sample.t - start_;
}

bool Metrics::is_finished(const DriveSample& sample) const {
  const Eigen::Vector2d p = sample.X_MB.position();
  if (const auto* region = std::get_if<RegionGoal>(&goal_))
    return (p.array() >= region->low.array()).all() && (p.array() <= region->high.array()).all();
  if (const auto* pose = std::get_if<PoseGoal>(&goal_))
    return position_error(goal_, p) <= pose->tolerance;
  return sample.t - start_ >= std::get<RoamGoal>(goal_).time;
}

void Metrics::write(DriveResult& result) const {
  const auto* roam = std::get_if<RoamGoal>(&goal_);
  result.plan_ms = quantiles(result.counts.plan_ms);
  result.reached = finished_ && (!roam || path_length_ >= roam->distance);
  result.time_to_goal_s = result.reached ? time_to_goal_ : -1.0;
  result.simulated_s = last_.t - start_;
  result.collisions = last_.collisions;
  result.min_clearance_m = min_clearance_;
  result.path_length_m = path_length_;
  result.obedience_rms = observed_ > 0.0 ? std::sqrt(squared_difference_ / observed_) : 0.0;
  result.stuck_s = stuck_;
  result.final_position_error_m = position_error(goal_, last_.X_MB.position());
}

void to_json(nlohmann::json& json, const DriveResult& r) {
  const Quantiles& ms = r.plan_ms;
  json = {{"scenario", r.scenario},
          {"map", r.map},
          {"method", r.method},
          {"driver", r.driver},
          {"seed", r.seed},
          {"lockstep", r.lockstep},
          {"reached", r.reached},
          {"time_to_goal_s", r.time_to_goal_s},
          {"simulated_s", r.simulated_s},
          {"wall_s", r.wall_s},
          {"collisions", r.collisions},
          {"min_clearance_m", r.min_clearance_m},
          {"path_length_m", r.path_length_m},
          {"obedience_rms", r.obedience_rms},
          {"filter_commands", r.counts.filter_commands},
          {"filter_interventions", r.counts.filter_interventions},
          {"stuck_s", r.stuck_s},
          {"final_position_error_m", r.final_position_error_m},
          {"plan_ms", {{"p50", ms.p50}, {"p95", ms.p95}, {"p99", ms.p99}, {"max", ms.max}}},
          {"plans", r.counts.plans},
          {"plan_fallbacks", r.counts.plan_fallbacks},
          {"plan_overruns", r.counts.plan_overruns},
          {"failures", r.failures}};
}

void from_json(const nlohmann::json& json, DriveResult& r) {
  json.at("scenario").get_to(r.scenario);
  json.at("map").get_to(r.map);
  json.at("method").get_to(r.method);
  json.at("driver").get_to(r.driver);
  json.at("seed").get_to(r.seed);
  json.at("lockstep").get_to(r.lockstep);
  json.at("reached").get_to(r.reached);
  json.at("time_to_goal_s").get_to(r.time_to_goal_s);
  json.at("simulated_s").get_to(r.simulated_s);
  json.at("wall_s").get_to(r.wall_s);
  json.at("collisions").get_to(r.collisions);
  json.at("min_clearance_m").get_to(r.min_clearance_m);
  json.at("path_length_m").get_to(r.path_length_m);
  json.at("obedience_rms").get_to(r.obedience_rms);
  json.at("filter_commands").get_to(r.counts.filter_commands);
  json.at("filter_interventions").get_to(r.counts.filter_interventions);
  json.at("stuck_s").get_to(r.stuck_s);
  json.at("final_position_error_m").get_to(r.final_position_error_m);
  const auto& ms = json.at("plan_ms");
  r.plan_ms = {ms.at("p50"), ms.at("p95"), ms.at("p99"), ms.at("max")};
  json.at("plans").get_to(r.counts.plans);
  json.at("plan_fallbacks").get_to(r.counts.plan_fallbacks);
  json.at("plan_overruns").get_to(r.counts.plan_overruns);
  json.at("failures").get_to(r.failures);
}

}  // namespace tandem
