// SPDX-License-Identifier: Apache-2.0
#include "tandem/metrics/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace tandem {
namespace {

constexpr double kPushes = 0.1;       // [m/s, rad/s] above it the person wants to move
constexpr double kStands = 0.03;      // [m/s]
constexpr double kStandsTurn = 0.05;  // [rad/s]
constexpr double kTravels = 0.05;     // [m/s] slower does not count as driving
constexpr double kStickSide = 0.1;    // share of the limit that counts as turning

bool stands(const Twist2& twist) {
  return std::abs(twist.v) < kStands && std::abs(twist.w) < kStandsTurn;
}

bool is_stuck(const DriveSample& sample) {
  const bool pushes = std::abs(sample.user.v) > kPushes || std::abs(sample.user.w) > kPushes;
  return pushes && stands(sample.twist);
}

double heading_error(const PoseGoal& goal, const Pose2& X_MB) {
  return std::abs(wrap_angle(X_MB.theta - goal.X_MG.theta));
}

double position_error(const Goal& goal, const Eigen::Vector2d& p_MB) {
  const auto place = place_of(goal);
  return place ? (*place - p_MB).norm() : 0.0;
}

}  // namespace

std::optional<Eigen::Vector2d> place_of(const Goal& goal) {
  if (const auto* region = std::get_if<RegionGoal>(&goal))
    return 0.5 * (region->low + region->high);
  if (const auto* pose = std::get_if<PoseGoal>(&goal)) return pose->X_MG.position();
  return std::nullopt;
}

bool is_at(const Goal& goal, const Eigen::Vector2d& p) {
  if (const auto* region = std::get_if<RegionGoal>(&goal))
    return (p.array() >= region->low.array()).all() && (p.array() <= region->high.array()).all();
  if (const auto* pose = std::get_if<PoseGoal>(&goal))
    return position_error(goal, p) <= pose->tolerance;
  return false;
}

Quantiles quantiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank = [&](double share) {
    const auto i = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
    return values[std::clamp<std::size_t>(i, 1, values.size()) - 1];
  };
  return {rank(0.5), rank(0.95), rank(0.99), values.back()};
}

void DriveCounts::on_filtered(double t, bool changed) {
  // The tolerance keeps rounding errors from moving a report into the previous interval.
  const auto look = static_cast<long>(std::floor(t / kFilterLook + 1e-6));
  if (std::exchange(last_look_, look) == look) return;
  ++filter_commands;
  if (changed) ++filter_interventions;
  if (changed && !was_changed_) ++filter_episodes;
  was_changed_ = changed;
}

long NodeTotal::growth(std::uint64_t total, bool just_begun) {
  const std::uint64_t before = last_.value_or(just_begun ? 0 : total);
  last_ = total;
  return static_cast<long>(total >= before ? total - before : total);
}

void Metrics::add(const DriveSample& sample) {
  if (!started_) {
    started_ = true;
    start_ = sample.t;
    last_ = sample;
  }
  const double dt = sample.t - last_.t;
  if (!(dt >= 0.0)) return;
  path_length_ += (sample.X_MB.position() - last_.X_MB.position()).norm();
  min_clearance_ = std::min(min_clearance_, sample.clearance);
  clearance_.add(std::min(sample.clearance, kFarClearance), dt);
  if (is_stuck(sample)) stuck_ += dt;
  compare(sample, dt);
  watch_stick(sample);
  watch_travel(sample);
  v_.add(sample.t, sample.twist.v);
  w_.add(sample.t, sample.twist.w);
  last_ = sample;
  if (finished_ || !is_finished(sample)) return;
  finished_ = true;
  time_to_goal_ = at_rest_.value_or(sample.t) - start_;
}

Eigen::Vector2d Metrics::in_limits(const Twist2& twist) const {
  return {twist.v / setting_.v_max, twist.w / setting_.w_max};
}

void Metrics::compare(const DriveSample& sample, double dt) {
  const Eigen::Vector2d u = in_limits(sample.user), r = in_limits(sample.twist);
  const double asked = u.norm(), done = r.norm();
  squared_difference_.add(0.5 * (u - r).squaredNorm(), dt);  // (1)
  if (asked <= kMoves) return;
  asked_ += asked * dt;  // (3)
  done_ += done * dt;
  if (done <= kMoves) return;
  const double cosine = std::clamp(u.dot(r) / (asked * done), -1.0, 1.0);  // (2)
  direction_.add(cosine, dt);
  if (sample.clearance >= kFree) direction_free_.add(cosine, dt);
}

void Metrics::watch_stick(const DriveSample& sample) {
  const Eigen::Vector2d u = in_limits(sample.user);
  stick_travel_ += (u - in_limits(last_.user)).norm();  // (4)
  if (std::abs(u.y()) < kStickSide) return;
  const int side = u.y() > 0.0 ? 1 : -1;
  if (side == -stick_side_) ++stick_reversals_;
  stick_side_ = side;
}

// Tracks the distance travelled each time after the stick comes to rest; the longest counts.
void Metrics::watch_travel(const DriveSample& sample) {
  const bool pushes = in_limits(sample.user).norm() > kMoves;
  if (pushes)
    rolled_.reset();
  else if (in_limits(last_.user).norm() > kMoves)
    rolled_ = 0.0;
  else if (rolled_)
    *rolled_ += (sample.X_MB.position() - last_.X_MB.position()).norm();
  if (rolled_) way_to_rest_ = std::max(way_to_rest_.value_or(0.0), *rolled_);
  if (std::abs(sample.twist.v) < kTravels) return;
  const int side = sample.twist.v > 0.0 ? 1 : -1;
  if (side == -travel_side_) ++travel_reversals_;
  travel_side_ = side;
}

bool Metrics::is_finished(const DriveSample& sample) {
  if (const auto* roam = std::get_if<RoamGoal>(&setting_.goal))
    return sample.t - start_ >= roam->time;
  const Eigen::Vector2d p_MB = sample.X_MB.position();
  was_after_ = was_after_ || !setting_.after ||
               is_at(*setting_.after, transform(sample.X_MB, setting_.p_BA));
  const auto* pose = std::get_if<PoseGoal>(&setting_.goal);
  const bool looks = !pose || heading_error(*pose, sample.X_MB) <= pose->heading_tolerance;
  const bool is_there = was_after_ && looks && is_at(setting_.goal, p_MB);
  if (!is_there || !stands(sample.twist)) at_rest_.reset();
  if (!pose || pose->stand <= 0.0) return is_there;
  if (is_there && stands(sample.twist) && !at_rest_) at_rest_ = sample.t;
  return at_rest_ && sample.t - *at_rest_ >= pose->stand;
}

void Metrics::write(DriveResult& result) const {
  const auto* roam = std::get_if<RoamGoal>(&setting_.goal);
  result.plan_ms = quantiles(result.counts.plan_ms);
  result.missed_deadlines =
      std::count_if(result.counts.plan_ms.begin(), result.counts.plan_ms.end(),
                    [&](double ms) { return ms > 1e3 * setting_.control_period; });
  result.reached = finished_ && (!roam || path_length_ >= roam->distance);
  result.time_to_goal_s = result.reached ? time_to_goal_ : -1.0;
  result.simulated_s = last_.t - start_;
  result.collisions = last_.collisions;
  result.min_clearance_m = min_clearance_;
  result.mean_clearance_m = clearance_.value().value_or(0.0);
  result.path_length_m = path_length_;
  if (result.reached && setting_.shortest_path.value_or(0.0) > 0.0)
    result.path_ratio = path_length_ / *setting_.shortest_path;
  result.obedience_rms = std::sqrt(squared_difference_.value().value_or(0.0));
  result.agreement_direction = direction_.value();
  result.agreement_direction_free = direction_free_.value();
  if (asked_ > 0.0) result.agreement_magnitude = done_ / asked_;
  result.stuck_s = stuck_;
  if (result.simulated_s > 0.0) result.stick_travel_per_s = stick_travel_ / result.simulated_s;
  result.stick_reversals = stick_reversals_;
  result.jerk_rms = rms_of_second_difference(v_.means());
  result.angular_jerk_rms = rms_of_second_difference(w_.means());
  std::vector<double> speed;
  for (const double v : v_.means()) speed.push_back(std::abs(v));
  result.spectral_arc_length = spectral_arc_length(speed);
  result.travel_reversals = travel_reversals_;
  result.way_to_rest_m = way_to_rest_;
  result.final_clearance_m = std::min(last_.clearance, kFarClearance);
  if (const auto* pose = std::get_if<PoseGoal>(&setting_.goal))
    result.final_heading_error_rad = heading_error(*pose, last_.X_MB);
  result.final_position_error_m = position_error(setting_.goal, last_.X_MB.position());
}

namespace {

// One list of field names for reading and writing.
template <class Result, class Field>
void visit(Result& r, Field field) {
  field("scenario", r.scenario);
  field("map", r.map);
  field("method", r.method);
  field("driver", r.driver);
  field("seed", r.seed);
  field("lockstep", r.lockstep);
  field("reached", r.reached);
  field("time_to_goal_s", r.time_to_goal_s);
  field("simulated_s", r.simulated_s);
  field("wall_s", r.wall_s);
  field("cpu_s", r.cpu_s);
  field("part_s", r.part_s);
  field("collisions", r.collisions);
  field("walked_into", r.walked_into);
  field("min_clearance_m", r.min_clearance_m);
  field("mean_clearance_m", r.mean_clearance_m);
  field("path_length_m", r.path_length_m);
  field("free_time_s", r.free_time_s);
  field("time_ratio", r.time_ratio);
  field("barn_score", r.barn_score);
  field("path_ratio", r.path_ratio);
  field("obedience_rms", r.obedience_rms);
  field("agreement_direction", r.agreement_direction);
  field("agreement_direction_free", r.agreement_direction_free);
  field("agreement_magnitude", r.agreement_magnitude);
  field("filter_commands", r.counts.filter_commands);
  field("filter_interventions", r.counts.filter_interventions);
  field("filter_episodes", r.counts.filter_episodes);
  field("stuck_s", r.stuck_s);
  field("stick_travel_per_s", r.stick_travel_per_s);
  field("stick_reversals", r.stick_reversals);
  field("jerk_rms", r.jerk_rms);
  field("angular_jerk_rms", r.angular_jerk_rms);
  field("spectral_arc_length", r.spectral_arc_length);
  field("travel_reversals", r.travel_reversals);
  field("way_to_rest_m", r.way_to_rest_m);
  field("final_position_error_m", r.final_position_error_m);
  field("final_heading_error_rad", r.final_heading_error_rad);
  field("final_clearance_m", r.final_clearance_m);
  field("plan_ms", r.plan_ms);
  field("plans", r.counts.plans);
  field("plan_fallbacks", r.counts.plan_fallbacks);
  field("plan_overruns", r.counts.plan_overruns);
  field("missed_deadlines", r.missed_deadlines);
  field("failures", r.failures);
}

template <class Times, class Field>
void visit_parts(Times& times, Field field) {
  field("setup", times.setup);
  field("simulator", times.simulator);
  field("extractor", times.extractor);
  field("planner", times.planner);
  field("filter", times.filter);
  field("person", times.person);
  field("measures", times.measures);
}

template <class T>
void put(nlohmann::json& json, const T& value) {
  json = value;
}
template <class T>
void put(nlohmann::json& json, const std::optional<T>& value) {
  if (value) json = *value;  // otherwise null
}
template <class T>
void get(const nlohmann::json& json, T& value) {
  json.get_to(value);
}
template <class T>
void get(const nlohmann::json& json, std::optional<T>& value) {
  value = json.is_null() ? std::nullopt : std::optional{json.get<T>()};
}

}  // namespace

void to_json(nlohmann::json& json, const PartTimes& times) {
  visit_parts(times, [&](const char* name, double value) { json[name] = value; });
}

void from_json(const nlohmann::json& json, PartTimes& times) {
  visit_parts(times, [&](const char* name, double& value) { json.at(name).get_to(value); });
}

void to_json(nlohmann::json& json, const Quantiles& q) {
  json = {{"p50", q.p50}, {"p95", q.p95}, {"p99", q.p99}, {"max", q.max}};
}

void from_json(const nlohmann::json& json, Quantiles& q) {
  q = {json.at("p50"), json.at("p95"), json.at("p99"), json.at("max")};
}

void to_json(nlohmann::json& json, const DriveResult& result) {
  json = nlohmann::json::object();
  visit(result, [&](const char* name, const auto& value) { put(json[name], value); });
}

void from_json(const nlohmann::json& json, DriveResult& result) {
  visit(result, [&](const char* name, auto& value) { get(json.at(name), value); });
}

}  // namespace tandem
