// SPDX-License-Identifier: Apache-2.0
#include "safety_filter/safety_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kClearanceCap = 1.0;  // [m] reported clearance ends here
constexpr double kBlocked = 0.05;      // an arc of which less than this passes counts as blocked
constexpr int kBisections = 6;

constexpr Twist2 kRest{};

Footprint scaled(const Footprint& footprint, double scale) {
  Footprint result = footprint;
  for (auto& p_BV : result.p_BV) p_BV *= scale;
  return result;
}

double hard_margin_of(const SafetyFilterParams& params, double radius) {
  return params.position_error + radius * params.heading_error + params.reserve +
         0.5 * kCheckSpacing;
}

}  // namespace

const char* name(FilterReason reason) {
  switch (reason) {
    case FilterReason::kClear:
      return "clear";
    case FilterReason::kSlowed:
      return "slowed";
    case FilterReason::kDeflected:
      return "deflected";
    case FilterReason::kBackingOut:
      return "backing out";
    case FilterReason::kStopped:
      return "stopped";
    case FilterReason::kNoCommand:
      return "no command";
    case FilterReason::kNotFinite:
      return "command not finite";
    case FilterReason::kNotLocalized:
      return "not localized";
    case FilterReason::kNoMap:
      return "no map";
  }
  return "unknown";
}

struct SafetyFilter::Scene {
  Pose2 X_MB;  // measured at start.t_measured
  MotionStart start;
  const StaticMap* map;
  Body body;
  RequiredClearance required;
  double clearance = 0.0;  // [m] of the whole body
};

SafetyFilter::SafetyFilter(const SafetyFilterParams& params, const RobotParams& robot)
    : params_{params}, robot_{robot} {
  check(params);
  check(robot);
  const Footprint footprint = footprint_of(robot);
  body_ = {footprint, circumradius(footprint), robot.wheel_separation};
  hard_margin_ = hard_margin_of(params, body_.radius);
  hold_ = params.survive_silence ? std::max(params.control_period, robot.command_timeout)
                                 : params.control_period;
  bounds_ = {robot.command_delay + robot.motor_lag, robot.a_brake, robot.alpha_brake,
             params.brake_spread};
}

void SafetyFilter::on_command(const Twist2& twist, double t) { command_ = TimedTwist{twist, t}; }

Filtered SafetyFilter::update(const std::optional<RobotState>& state, double now) {
  Filtered out = decide(state, now);
  const bool drives =
      out.reason != FilterReason::kNoCommand && out.reason != FilterReason::kNotFinite;
  out.twist = !params_.enforce && drives ? out.requested : out.safe;
  remember(out.twist, now);
  return out;
}

Filtered SafetyFilter::decide(const std::optional<RobotState>& state, double now) const {
  Filtered out;
  if (!command_ || !(now - command_->t <= params_.command_timeout)) return out;
  out.requested = command_->twist;
  if (!is_finite(command_->twist)) {
    out.reason = FilterReason::kNotFinite;
  } else if (!map_) {
    out.reason = FilterReason::kNoMap;
  } else if (!state) {
    out.reason = FilterReason::kNotLocalized;
  } else {
    out = filter(command_->twist, *state, *map_, now);
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
  const Scene scene = look_at(state, map, now);
  out.clearance = scene.clearance;
  const Twist2 wanted = limit(command, robot_);
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
                                          double now) const {
  Scene scene;
  scene.X_MB = state.X_MB;
  scene.start.measured = state.twist;
  scene.start.t_measured = std::min(state.t, now) - robot_.sensor_delay;
  scene.start.now = now;
  scene.start.sent = sent_;
  scene.map = &map;
  scene.body = body_;
  scene.clearance = map.clearance(body_.footprint, state.X_MB, kClearanceCap);

  const double full = hard_margin_ + params_.band;
  scene.required.level = scene.clearance >= full ? full : std::min(scene.clearance, hard_margin_);
  // On contact the outline says nothing about the way out; a smaller one does.
  for (const double scale : {0.95, 0.85, 0.7, 0.5, 0.2}) {
    if (scene.required.level > 0.0) break;
    scene.body.footprint = scaled(body_.footprint, scale);
    scene.required.level = map.clearance(scene.body.footprint, state.X_MB, kClearanceCap);
  }
  scene.required.per_rim = params_.slip * (0.5 + body_.radius / robot_.wheel_separation);  // (2)
  scene.required.per_path = params_.heading_error;
  return scene;
}

bool SafetyFilter::is_safe(const Twist2& command, double hold, const Scene& scene) const {
  MotionStart start = scene.start;
  start.command = command;
  start.hold = hold;
  const Reach way = reach(start, bounds_);
  const auto& required = scene.required;
  const double rims = 2.0 * way.path + robot_.wheel_separation * way.turn;
  if (scene.clearance > required.level + required.per_rim * rims + required.per_path * way.path +
                            way.path + body_.radius * way.turn)
    return true;
  for (const Extreme v : {Extreme::kHigh, Extreme::kLow})
    for (const Extreme w : {Extreme::kHigh, Extreme::kLow}) {
      const Motion motion = extreme_motion(start, bounds_, v, w);
      if (!stays_clear(motion, scene.X_MB, scene.body, *scene.map, required)) return false;
    }
  return true;
}

double SafetyFilter::largest_safe_scale(const Twist2& command, const Scene& scene) const {
  if (is_safe(command, hold_, scene)) return 1.0;
  double safe = 0.0, unsafe = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (safe + unsafe);
    (is_safe({middle * command.v, middle * command.w}, hold_, scene) ? safe : unsafe) = middle;
  }
  return safe;
}

void SafetyFilter::reduce(Filtered& out, const Twist2& command, const Scene& scene) const {
  out.reason = FilterReason::kStopped;
  if (!is_safe(kRest, 0.0, scene)) return;  // zero now, or nobody knows where it ends

  Twist2 along = command;
  out.scale = largest_safe_scale(along, scene);
  if (out.scale < kBlocked && command.v != 0.0 && command.w != 0.0) {
    for (const Twist2& part : {Twist2{0.0, command.w}, Twist2{command.v, 0.0}}) {
      const double scale = largest_safe_scale(part, scene);
      if (scale <= out.scale) continue;
      out.scale = scale;
      along = part;
    }
  }
  if (out.scale == 0.0) return;
  out.safe = {out.scale * along.v, out.scale * along.w};
  const bool inside = scene.clearance < hard_margin_;
  out.reason = along != command            ? FilterReason::kDeflected
               : out.scale < 1.0           ? FilterReason::kSlowed
               : out.safe != out.requested ? FilterReason::kSlowed
               : inside                    ? FilterReason::kBackingOut
                                           : FilterReason::kClear;
}

void SafetyFilter::remember(const Twist2& twist, double now) {
  const double horizon = params_.state_timeout + robot_.sensor_delay + bounds_.delay;
  std::size_t old = 0;
  while (old + 1 < sent_.size() && sent_[old + 1].t < now - horizon) ++old;
  sent_.erase(sent_.begin(), sent_.begin() + static_cast<std::ptrdiff_t>(old));
  if (sent_.empty() || sent_.back().twist != twist) sent_.push_back({twist, now});
}

}  // namespace tandem
