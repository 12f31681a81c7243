// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/safety_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "tandem/model/diff_drive.hpp"
#include "tandem/safety_filter/share_cover.hpp"
#include "tandem/safety_filter/unseen_check.hpp"

namespace tandem {
namespace {

constexpr double kClearanceCap = 1.0;  // [m] largest clearance that is reported
constexpr double kBlocked = 0.05;  // an arc counts as blocked if a smaller fraction of it passes
constexpr int kBisections = 6;
constexpr double kLittleMore = 1.0 / 64.0;  // resolution of the bisection
constexpr int kMaxSteps = 16;  // samples of odometry's age, and of the time at which zero acts

constexpr double kMoves = 0.005;  // [m/s, rad/s] smaller commands do not move the robot

constexpr double kTooFastFactor = 1.5,
                 kTooFastMore = 0.2;  // factor, offset [m/s, rad/s]

constexpr Twist2 kRest{};

bool moves(const Twist2& twist) {
  return std::abs(twist.v) >= kMoves || std::abs(twist.w) >= kMoves;
}

Twist2 scaled(const Twist2& twist, double scale) { return {scale * twist.v, scale * twist.w}; }

// Number of steps to divide `duration` into so that the robot moves in each by no more than
// neighbouring motions may be apart.
int steps_of(double duration, const Twist2& twist, double lever) {
  if (duration <= 0.0) return 0;
  const double gaps =
      duration * std::max(std::abs(twist.v) / kPathGap, std::abs(twist.w) * lever / kTurnGap);
  return std::max(1, static_cast<int>(std::ceil(std::min(gaps, 1e6))));
}

double hard_margin_of(const SafetyFilterParams& params, double radius) {
  return params.position_error + radius * params.heading_error + params.reserve +
         0.5 * kCheckSpacing;
}

}  // namespace

struct SafetyFilter::Scene {
  Pose2 X_MB;          // measured pose
  double measured_by;  // [s] latest time of the measurement; it may be sensor_delay older
  MotionStart start;
  const StaticMap* map;
  RequiredClearance required;
  double clearance = 0.0;  // [m] of the whole outline
  const StaticMap* unseen = nullptr;
  double unseen_clearance = 0.0;  // [m] to unseen ground
};

SafetyFilter::SafetyFilter(const SafetyFilterParams& params, const RobotParams& robot)
    : params_{params},
      robot_{robot},
      twist_check_{{.resolution = params.odom_resolution,
                    .age = robot.sensor_delay,
                    .slip = params.slip,
                    .command_delay = robot.command_delay}} {
  check(params);
  check(robot);
  if (params.survive_silence && robot.base_timeout == 0.0)
    throw std::invalid_argument(
        "survive_silence needs a base that stops by itself (base_timeout above 0); with "
        "survive_silence: false the robot may hit an obstacle if this filter fails");
  const Footprint footprint = footprint_of(robot);
  body_ = {footprint, circumradius(footprint)};
  hard_margin_ = hard_margin_of(params, body_.radius);
  hold_ = params.survive_silence ? std::max(params.control_period, robot.base_timeout)
                                 : params.control_period;
  bounds_ = {robot.command_delay, robot.motor_lag, robot.a_brake, robot.alpha_brake,
             params.brake_spread};
  drift_ = {params.slip, params.heading_error, robot.wheel_separation, body_.radius};
  people_check_.emplace(params.people, robot, body_);
  unseen_check_ =
      std::make_shared<const UnseenCheck>(params.unseen_speed, body_, robot.wheel_separation);
  jumped_until_ = -std::numeric_limits<double>::infinity();
}

void SafetyFilter::on_command(const Twist2& twist, double t) { command_ = {twist, t}; }

Filtered SafetyFilter::update(const std::optional<RobotState>& state, double now) {
  if (state) on_state(*state, now);
  Filtered out = decide(state, now);
  const bool drives =
      out.reason != FilterReason::kNoCommand && out.reason != FilterReason::kNotFinite;
  out.twist = !params_.enforce && drives ? out.requested : out.safe;
  out.twist_contradicted = twist_check_.is_contradicted();
  out.refused = out.reason < FilterReason::kNoCommand && moves(out.requested) && !moves(out.twist);
  remember(out.twist, now);
  return out;
}

Filtered SafetyFilter::stop(FilterReason reason, double now) {
  Filtered out;
  out.reason = reason;
  remember(out.twist, now);
  return out;
}

void SafetyFilter::on_time_jump(double now) {
  command_.reset();
  twist_check_.clear();
  people_.reset();
  jumped_until_ = std::min(jumped_until_, now + params_.jump_rest);
  if (!sent_.empty()) sent_.assign(1, {sent_.back().value, now});
}

// Detects a jump: the pose must move as the wheels predict, within tolerances for late odometry and
// for what the wheels may have done during a longer gap.
void SafetyFilter::on_state(const RobotState& state, double now) {
  if (!is_finite(state.X_MB) || !is_finite(state.twist)) return;
  if (state.X_WB) twist_check_.on_odometry(*state.X_WB, state.twist, state.t);
  const auto last = std::exchange(last_state_, state);
  if (!last || state.t < last->t) return;
  const double dt = state.t - last->t;
  const Twist2 mean{0.5 * (last->twist.v + state.twist.v), 0.5 * (last->twist.w + state.twist.w)};
  const Pose2 expected = integrate(last->X_MB, mean, dt);
  const double late = std::max(0.5 * params_.state_timeout, dt) + robot_.sensor_delay;
  const double off = (state.X_MB.position() - expected.position()).norm();
  const double turned = std::abs(wrap_angle(state.X_MB.theta - expected.theta));
  if (off > params_.jump_distance + late * std::abs(mean.v) ||
      turned > params_.jump_angle + late * std::abs(mean.w))
    jumped_until_ = now + params_.jump_rest;
}

Filtered SafetyFilter::decide(const std::optional<RobotState>& state, double now) const {
  Filtered out;
  if (!command_.fresh(now, params_.arbitrated_timeout)) return out;
  out.requested = command_.value;
  if (!is_finite(command_.value)) {
    out.reason = FilterReason::kNotFinite;
  } else if (!map_) {
    out.reason = FilterReason::kNoMap;
  } else if (!state) {
    out.reason = FilterReason::kNotLocalized;
  } else if (now < jumped_until_) {
    out.reason = FilterReason::kPoseJumped;
  } else if (is_too_fast(state->twist)) {
    out.reason = FilterReason::kTooFast;
  } else if (params_.people.watched && !people_.fresh(now, params_.people.people_timeout)) {
    out.reason = FilterReason::kNoPeople;
  } else {
    out = filter(command_.value, *state, *map_, now);
  }
  return out;
}

Filtered SafetyFilter::filter(const Twist2& command, const RobotState& state, const StaticMap& map,
                              double now) const {
  Filtered out;
  out.requested = command;
  if (!is_finite(command)) {
    out.reason = FilterReason::kNotFinite;
    return out;
  }
  if (!is_finite(state.X_MB) || !is_finite(state.twist) ||
      !(now - state.t <= params_.state_timeout)) {
    out.reason = FilterReason::kNotLocalized;
    return out;
  }
  const Twist2 wanted = limit(command, robot_);
  const Scene scene = look_at(state, map, wanted, now);
  out.clearance = scene.clearance;
  if (wanted == kRest) {
    out.scale = 1.0;
    out.reason = FilterReason::kClear;
    return out;
  }
  reduce(out, wanted, scene);
  out.twist = out.safe;
  return out;
}

SafetyFilter::Scene SafetyFilter::look_at(const RobotState& state, const StaticMap& map,
                                          const Twist2& wanted, double now) const {
  Scene scene;
  scene.X_MB = state.X_MB;
  scene.measured_by = std::min(state.t, now);
  scene.start.measured = state.twist;
  const TwistError error = twist_check_.error(state.twist);
  scene.start.below = error.below;
  scene.start.above = error.above;
  scene.start.now = now;
  scene.start.sent = sent_;
  scene.map = &map;
  scene.clearance = map.clearance(body_.footprint, state.X_MB, kClearanceCap);
  const double level = required_level(wanted, scene.clearance);
  scene.required = {.level = level, .drift = drift_};
  if (scene.clearance < level)
    scene.required =
        required_clearance(level, state.X_MB, params_.position_error, body_, map, drift_);
  if (!unseen_ || unseen_check_->is_slow({std::max(robot_.v_max, -robot_.v_min), robot_.w_max}))
    return scene;
  scene.unseen = unseen_.get();
  scene.unseen_clearance = unseen_->clearance(body_.footprint, state.X_MB, kClearanceCap);
  return scene;
}

// The threshold is well above the limit: a base may overshoot, and the configured limit may be
// lower than what the base can do.
bool SafetyFilter::is_too_fast(const Twist2& measured) const {
  const auto beyond = [](double speed, double limit) {
    return std::abs(speed) > kTooFastFactor * limit + kTooFastMore;
  };
  const double v_max = std::max(robot_.v_max, -robot_.v_min);
  const Twist2 posed = twist_check_.least_speed();
  return beyond(measured.v, v_max) || beyond(posed.v, v_max) || beyond(measured.w, robot_.w_max) ||
         beyond(posed.w, robot_.w_max);
}

double SafetyFilter::required_level(const Twist2& wanted, double clearance) const {
  const double full = hard_margin_ + params_.band;
  const bool manoeuvres =
      std::abs(wanted.v) + body_.radius * std::abs(wanted.w) <= params_.manoeuvre_speed;
  return clearance >= full && !manoeuvres ? full : hard_margin_;
}

// The command acts until zero does: at the earliest immediately, if the next call sends zero
// without delay, at the latest after hold_ plus the longest command delay.
bool SafetyFilter::is_safe(const Twist2& command, const Scene& scene) const {
  MotionStart start = scene.start;
  start.command = command;
  start.t_measured = scene.measured_by - robot_.sensor_delay;
  const double latest = robot_.command_delay + (command == kRest ? 0.0 : hold_);
  start.end = latest;
  const Farthest farthest = farthest_motion(start, bounds_);
  if (are_walls_far(farthest.path, farthest.turn, scene) && !params_.people.watched &&
      (is_unseen_far(farthest.path, farthest.turn, scene) ||
       unseen_check_->is_slow({farthest.speed, farthest.turn_rate})))
    return true;
  const double lever = farthest.path + body_.radius;
  const int ends = command == kRest ? 1 : std::max(1, steps_of(latest, command, lever));
  const int ages = steps_of(robot_.sensor_delay, {farthest.speed, farthest.turn_rate}, lever);
  if (ends > kMaxSteps || ages > kMaxSteps) return false;
  for (int i = ends; i > 0; --i) {
    start.end = latest * i / ends;
    if (!is_safe_at_any_age(start, ages, scene)) return false;
  }
  return true;
}

// The age of odometry is unknown up to its bound, so all ages are checked.
bool SafetyFilter::is_safe_at_any_age(MotionStart start, int steps, const Scene& scene) const {
  for (int i = steps; i >= 0; --i) {
    start.t_measured = scene.measured_by - robot_.sensor_delay * i / std::max(1, steps);
    if (!is_safe_from(start, scene)) return false;
  }
  return true;
}

bool SafetyFilter::are_walls_far(double path, double turn, const Scene& scene) const {
  return scene.clearance >
         scene.required.level + path + body_.radius * turn + largest_deviation(path, turn, drift_);
}

bool SafetyFilter::is_unseen_far(double path, double turn, const Scene& scene) const {
  return !scene.unseen || scene.unseen_clearance > kUnseenEdge + kCheckSpacing + path +
                                                       (body_.radius + kUnseenEdge) * turn;
}

bool SafetyFilter::is_safe_from(const MotionStart& start, const Scene& scene) const {
  const StoppingEnvelope envelope = stopping_envelope(start, bounds_);
  const Reach way = reach(envelope);
  const bool walls_far = are_walls_far(way.path, way.turn, scene);
  const double away =
      way.path + body_.radius * way.turn + largest_deviation(way.path, way.turn, drift_);
  const bool people_far =
      !params_.people.watched ||
      people_check_->is_far(people_, scene.X_MB, hard_margin_ + away, start.t_measured, way.time);
  const Twist2 low = start.lowest(), high = start.highest();
  const Twist2 fastest{std::max(std::abs(low.v), std::abs(high.v)),
                       std::max(std::abs(low.w), std::abs(high.w))};
  const auto fast =
      scene.unseen ? unseen_check_->fast_part(envelope, fastest) : std::span<const TwistRange>{};
  const BoundedFootprint& wide = unseen_check_->drawn_out(fast);
  const Reach fast_way = reach(fast);
  const bool unseen_far = is_unseen_far(fast_way.path, fast_way.turn, scene) || fast.empty();
  if (walls_far && people_far && unseen_far) return true;
  const auto is_clear = [&](const ShareCell& cell) {
    return (unseen_far || unseen_check_->stays_off(fast, cell, scene.X_MB, wide, *scene.unseen)) &&
           (walls_far ||
            stays_clear(envelope, cell, scene.X_MB, body_, *scene.map, scene.required)) &&
           (people_far ||
            people_check_->keeps_away(envelope, cell, fastest, scene.X_MB, start.t_measured,
                                      people_, hard_margin_, drift_));
  };
  return all_motions_clear(way, way.path + body_.radius, is_clear);
}

// The fraction that is slow enough for unseen ground is tried first: bisection alone would not use
// all of unseen_speed.
double SafetyFilter::largest_safe_scale(const Twist2& command, const Scene& scene) const {
  if (is_safe(command, scene)) return 1.0;
  double safe = 0.0, unsafe = 1.0;
  if (const double slow = unseen_check_->slow_share(command);
      scene.unseen && slow < 1.0 && is_safe(scaled(command, slow), scene))
    safe = slow;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (safe + unsafe);
    (is_safe(scaled(command, middle), scene) ? safe : unsafe) = middle;
  }
  return safe;
}

void SafetyFilter::reduce(Filtered& out, const Twist2& command, const Scene& scene) const {
  out.reason =
      twist_check_.is_contradicted() ? FilterReason::kStoppedInDoubt : FilterReason::kStopped;
  if (is_safe(kRest, scene)) return reduce_to_safe(out, command, scene);
  if (scene.unseen) slow_down_for_unseen(out, command, scene);
}

// Called when even zero does not stop before unseen ground, because ground seen before has just
// expired. Walls still limit the command.
void SafetyFilter::slow_down_for_unseen(Filtered& out, const Twist2& command,
                                        const Scene& scene) const {
  Scene walls_only = scene;
  walls_only.unseen = nullptr;
  if (!is_safe(kRest, walls_only)) return;  // not even braking is known to be safe: send zero
  const double slow = unseen_check_->slow_share(command);
  reduce_to_safe(out, scaled(command, slow), walls_only);
  out.scale *= slow;
  if (slow < 1.0) out.reason = FilterReason::kUnseen;
}

void SafetyFilter::reduce_to_safe(Filtered& out, const Twist2& command, const Scene& scene) const {
  Twist2 along = command;
  out.scale = largest_safe_scale(along, scene);
  const bool unseen = is_unseen_in_the_way(command, out.scale, scene);
  if (unseen) out.reason = FilterReason::kUnseen;
  if (out.scale < kBlocked && command.v != 0.0 && command.w != 0.0) {
    for (const Twist2& part : {Twist2{0.0, command.w}, Twist2{command.v, 0.0}}) {
      const double scale = largest_safe_scale(part, scene);
      if (scale <= out.scale) continue;
      out.scale = scale;
      along = part;
    }
  }
  if (out.scale == 0.0) return;
  out.safe = scaled(along, out.scale);
  const bool inside = scene.clearance < hard_margin_;
  out.reason = unseen                      ? FilterReason::kUnseen
               : along != command          ? FilterReason::kDeflected
               : out.scale < 1.0           ? FilterReason::kSlowed
               : out.safe != out.requested ? FilterReason::kSlowed
               : inside                    ? FilterReason::kBackingOut
                                           : FilterReason::kClear;
}

// Whether unseen ground is the limit: slightly more than the safe fraction would pass if all ground
// were seen.
bool SafetyFilter::is_unseen_in_the_way(const Twist2& command, double safe_scale,
                                        const Scene& scene) const {
  if (!scene.unseen || safe_scale >= 1.0) return false;
  Scene walls_only = scene;
  walls_only.unseen = nullptr;
  return is_safe(scaled(command, std::min(1.0, safe_scale + kLittleMore)), walls_only);
}

void SafetyFilter::remember(const Twist2& twist, double now) {
  const double horizon = params_.state_timeout + robot_.sensor_delay + robot_.command_delay;
  std::size_t old = 0;
  while (old + 1 < sent_.size() && sent_[old + 1].t < now - horizon) ++old;
  sent_.erase(sent_.begin(), sent_.begin() + static_cast<std::ptrdiff_t>(old));
  if (sent_.empty() || sent_.back().value != twist) sent_.push_back({twist, now});
  twist_check_.on_command(twist, now);
}

}  // namespace tandem
