// SPDX-License-Identifier: Apache-2.0
#include "safety_filter/safety_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kClearanceCap = 1.0;  // [m] reported clearance ends here
constexpr double kBlocked = 0.05;      // an arc of which less than this passes counts as blocked
constexpr int kBisections = 6;
constexpr double kPathGap = 0.3;   // [m] between the ends of two motions that are looked at …
constexpr double kTurnGap = 0.10;  // [m] … and across their way
constexpr int kMostShares = 8;

constexpr double kMoves = 0.005;  // [m/s, rad/s] a command from here on moves the robot

constexpr Twist2 kRest{};

bool moves(const Twist2& twist) {
  return std::abs(twist.v) >= kMoves || std::abs(twist.w) >= kMoves;
}

// Into how many parts a range of speeds is cut.
int shares(double parts) { return std::clamp(static_cast<int>(std::ceil(parts)), 1, kMostShares); }

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
    case FilterReason::kPoseJumped:
      return "pose jumped";
    case FilterReason::kNoMap:
      return "no map";
    case FilterReason::kNoPeople:
      return "people silent";
    case FilterReason::kClockSilent:
      return "/clock is silent";
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
  if (params.survive_silence && robot.command_timeout == 0.0)
    throw std::invalid_argument(
        "survive_silence needs a base that stops by itself (command_timeout above 0); with "
        "survive_silence: false the loss of this filter is not survived");
  const Footprint footprint = footprint_of(robot);
  body_ = {footprint, circumradius(footprint), robot.wheel_separation};
  hard_margin_ = hard_margin_of(params, body_.radius);
  hold_ = params.survive_silence ? std::max(params.control_period, robot.command_timeout)
                                 : params.control_period;
  bounds_ = {robot.command_delay + robot.motor_lag, robot.a_brake, robot.alpha_brake,
             params.brake_spread};
  people_check_.emplace(params.people, robot, body_, params.brake_spread);
  jumped_until_ = updated_ = -std::numeric_limits<double>::infinity();
}

void SafetyFilter::on_command(const Twist2& twist, double t) { command_ = TimedTwist{twist, t}; }

Filtered SafetyFilter::update(const std::optional<RobotState>& state, double now) {
  watch_clock(now);
  if (state) on_state(*state, now);
  Filtered out = decide(state, now);
  const bool drives =
      out.reason != FilterReason::kNoCommand && out.reason != FilterReason::kNotFinite;
  out.twist = !params_.enforce && drives ? out.requested : out.safe;
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

// Where the clock was set back, what was heard before is of no known age; what was sent last acts.
void SafetyFilter::watch_clock(double now) {
  if (std::exchange(updated_, now) <= now) return;
  if (command_ && command_->t > now) command_.reset();
  if (people_.t > now) people_.t = -std::numeric_limits<double>::infinity();
  jumped_until_ = std::min(jumped_until_, now + params_.jump_rest);
  if (!sent_.empty()) sent_.assign(1, TimedTwist{sent_.back().twist, now});
}

// From one pose to the next the wheels must lead there, but for how late odometry may arrive, and
// for what they may have done in a silence that was longer.
void SafetyFilter::on_state(const RobotState& state, double now) {
  if (!is_finite(state.X_MB) || !is_finite(state.twist)) return;
  const auto last = std::exchange(last_state_, state);
  if (!last || state.t < last->t) return;
  const double dt = state.t - last->t;
  const Twist2 mean{0.5 * (last->twist.v + state.twist.v), 0.5 * (last->twist.w + state.twist.w)};
  const Pose2 expected = integrate(last->X_MB, mean, dt);
  const double late = std::max(0.5 * params_.state_timeout, dt);
  const double off = (state.X_MB.position() - expected.position()).norm();
  const double turned = std::abs(wrap_angle(state.X_MB.theta - expected.theta));
  if (off > params_.jump_distance + late * std::abs(mean.v) ||
      turned > params_.jump_angle + late * std::abs(mean.w))
    jumped_until_ = now + params_.jump_rest;
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
  } else if (now < jumped_until_) {
    out.reason = FilterReason::kPoseJumped;
  } else if (params_.people.watched && !(now - people_.t <= params_.people.people_timeout)) {
    out.reason = FilterReason::kNoPeople;
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
  scene.start.measured = state.twist;
  scene.start.t_measured = std::min(state.t, now) - robot_.sensor_delay;
  scene.start.now = now;
  scene.start.sent = sent_;
  scene.map = &map;
  scene.body = body_;
  scene.clearance = map.clearance(body_.footprint, state.X_MB, kClearanceCap);

  const double full = hard_margin_ + params_.band;
  const bool manoeuvres =
      std::abs(wanted.v) + body_.radius * std::abs(wanted.w) <= params_.manoeuvre_speed;
  scene.required.level =
      scene.clearance >= full && !manoeuvres ? full : std::min(scene.clearance, hard_margin_);
  // On contact the outline says nothing about the way out; a smaller one does.
  for (const double scale : {0.95, 0.85, 0.7, 0.5, 0.2}) {
    if (scene.required.level > 0.0) break;
    scene.body.footprint = shrunk(body_.footprint, scale);
    scene.required.level = map.clearance(scene.body.footprint, state.X_MB, kClearanceCap);
  }
  scene.required.per_rim = params_.slip * (0.5 + body_.radius / robot_.wheel_separation);  // (2)
  scene.required.per_path = params_.heading_error;
  return scene;
}

// Whether all possible motions are clear.
template <class Clear>
bool SafetyFilter::are_clear(const MotionStart& start, const Reach& way, const Clear& clear) const {
  const Motion low = possible_motion(start, bounds_, 0.0, 0.0);
  const Motion high = possible_motion(start, bounds_, 1.0, 1.0);
  if (!clear(low) || !clear(high)) return false;
  // The ends alone would miss what stands between them.
  const Spread apart = spread(low, high);
  const int n_v = shares(apart.path / kPathGap);
  const int n_w = shares(apart.turn * (way.path + body_.radius) / kTurnGap);
  for (int i = 0; i <= n_v; ++i)
    for (int j = 0; j <= n_w; ++j) {
      if ((i == 0 && j == 0) || (i == n_v && j == n_w)) continue;
      const double v = static_cast<double>(i) / n_v, w = static_cast<double>(j) / n_w;
      if (!clear(possible_motion(start, bounds_, v, w))) return false;
    }
  return true;
}

bool SafetyFilter::is_safe(const Twist2& command, double hold, const Scene& scene) const {
  MotionStart start = scene.start;
  start.command = command;
  start.hold = hold;
  const Reach way = reach(start, bounds_);
  const auto& required = scene.required;
  const double rims = 2.0 * way.path + robot_.wheel_separation * way.turn;
  const double away =
      required.per_rim * rims + required.per_path * way.path + way.path + body_.radius * way.turn;
  const bool walls_far = scene.clearance > required.level + away;
  const bool people_far =
      !params_.people.watched ||
      people_check_->is_far(people_, scene.X_MB, hard_margin_ + away, start.t_measured, way.time);
  if (walls_far && people_far) return true;
  RequiredClearance from_people = required;
  from_people.level = hard_margin_;
  return are_clear(start, way, [&](const Motion& motion) {
    return (walls_far || stays_clear(motion, scene.X_MB, scene.body, *scene.map, required)) &&
           (people_far || people_check_->keeps_away(motion, start.measured, scene.X_MB,
                                                    start.t_measured, people_, from_people));
  });
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
