// SPDX-License-Identifier: Apache-2.0
// The filter's guarantee as a property: rollouts to standstill of random robots with worst-case
// errors in random worlds. Shared by the test and by the long run started by hand.
#pragma once

#include <algorithm>

#include "safety_filter/attack.hpp"

namespace tandem::test {

/// How far the real base exceeds what the filter assumes, as multiples of each bound.
struct Beyond {
  double slip = 1.0;        ///< of the wheels' travel
  double lag = 1.0;         ///< of the motors
  double delay = 1.0;       ///< of commands and of odometry
  double pose_error = 1.0;  ///< of the localiser
  double braking = 1.0;     ///< divisor of a_brake and alpha_brake in the base
};

/// Totals over a number of rollouts.
struct Tally {
  long steps = 0;             ///< calls of the filter
  long rollouts = 0;          ///< to standstill
  long contacts = 0;          ///< with people: only while the robot moved
  long walked_into = 0;       ///< by people, while the robot stood
  unsigned contact_seed = 0;  ///< seed of a scene with a contact
  unsigned closest_seed = 0;  ///< seed of the scene of min_clearance
  long unfinished = 0;        ///< rollouts that did not come to rest
  double min_clearance = 1.0;
  double travel = 0.0;  ///< [m]

  void add(const Tally& other) {
    steps += other.steps;
    rollouts += other.rollouts;
    if (contacts == 0) contact_seed = other.contact_seed;
    contacts += other.contacts;
    walked_into += other.walked_into;
    unfinished += other.unfinished;
    if (other.min_clearance < min_clearance) closest_seed = other.closest_seed;
    min_clearance = std::min(min_clearance, other.min_clearance);
    travel += other.travel;
  }
};

/// A bound in seconds: often small, sometimes `large`.
inline double some_time(Random& random, double large) {
  switch (pick(random, 4)) {
    case 0:
      return 0.0;
    case 1:
      return uniform(random, 0.0, large);
    default:
      return uniform(random, 0.0, 0.08);
  }
}

/// Adds two forks in front of the robot's rectangle, each as a separate part.
inline void add_forks(RobotParams& robot, Random& random) {
  const double back = robot.center_x - 0.5 * robot.length, front = back + robot.length;
  const double tip = front + uniform(random, 0.1, 0.6), half = 0.5 * robot.width;
  const double wide = uniform(random, 0.1, 0.4) * half;
  robot.footprint = {back, -half,       front,       -half,       front,       half,
                     back, half,        front - .05, -half,       tip,         -half,
                     tip,  wide - half, front - .05, wide - half, front - .05, half - wide,
                     tip,  half - wide, tip,         half,        front - .05, half};
  robot.footprint_parts = {4, 4, 4};
}

/// A random robot that the parameters allow and that could plausibly be built.
inline RobotParams any_robot(Random& random) {
  RobotParams robot;
  robot.length = uniform(random, 0.3, 1.2);
  robot.width = uniform(random, 0.25, 0.8);
  robot.center_x = uniform(random, -0.48, 0.48) * robot.length;
  robot.wheel_separation = uniform(random, 0.6, 0.95) * robot.width;
  robot.v_max = uniform(random, 0.3, pick(random, 2) ? 1.5 : 3.0);
  robot.v_min = -uniform(random, 0.2, 1.0) * robot.v_max;
  robot.w_max = uniform(random, 0.5, 3.0);
  robot.a_brake = uniform(random, 0.5, 3.0);
  robot.alpha_brake = uniform(random, 1.0, 8.0);
  robot.motor_lag = some_time(random, 0.5);
  robot.command_delay = some_time(random, 0.3);
  robot.sensor_delay = some_time(random, 0.5);
  robot.base_timeout = uniform(random, 0.06, 0.3);
  if (pick(random, 6) == 0) add_forks(robot, random);
  return robot;
}

inline SafetyFilterParams any_filter(Random& random) {
  SafetyFilterParams params;
  params.survive_silence = pick(random, 2) == 0;
  params.control_period = pick(random, 2) ? 0.05 : uniform(random, 0.02, 0.1);
  params.state_timeout = pick(random, 2) ? 0.2 : uniform(random, 0.1, 0.5);
  params.position_error = pick(random, 2) ? 0.01 : uniform(random, 0.0, 0.03);
  params.heading_error = pick(random, 2) ? 0.01 : uniform(random, 0.0, 0.03);
  params.slip = pick(random, 2) ? 0.02 : uniform(random, 0.0, 0.05);
  params.brake_spread = uniform(random, 1.0, 2.0);
  return params;
}

/// Slip that is opposite on the two wheels, equal, arbitrary or zero; constant or slow.
inline void draw_slip(BaseBehaviour& base, double most, Random& random) {
  const double sign = pick(random, 2) ? 1.0 : -1.0;
  base.slip_period = pick(random, 2) ? 0.0 : uniform(random, 0.3, 20.0);
  switch (pick(random, 5)) {
    case 0:
      return;
    case 1:
      base.slip_left = base.slip_right = sign * most;
      return;
    case 2:
      base.slip_left = uniform(random, -most, most);
      base.slip_right = uniform(random, -most, most);
      return;
    default:
      base.slip_left = sign * most;
      base.slip_right = -sign * most;
  }
}

/// Often none of a bound or all of it, sometimes a part; in every second scene all that makes the
/// way to rest long, at once.
inline BaseBehaviour any_behaviour(const RobotParams& robot, const SafetyFilterParams& filter,
                                   const Beyond& beyond, Random& random) {
  BaseBehaviour base;
  const bool sluggish = pick(random, 2) == 0;
  const auto part = [&] { return sluggish ? 1.0 : fraction(random); };
  const auto stronger = [&] {
    return sluggish ? 1.0 : 1.0 + fraction(random) * (filter.brake_spread - 1.0);
  };
  base.lag = part() * beyond.lag * robot.motor_lag;
  base.brake = stronger() * robot.a_brake / beyond.braking;
  base.turn_brake = stronger() * robot.alpha_brake / beyond.braking;
  base.drive = pick(random, 3) ? uniform(random, 0.5, 8.0) : 100.0;
  base.turn_drive = pick(random, 3) ? uniform(random, 1.0, 16.0) : 300.0;
  base.longest_delay = part() * beyond.delay * robot.command_delay;
  base.shortest_delay = part() * base.longest_delay;
  base.timeout = robot.base_timeout;
  draw_slip(base, beyond.slip * filter.slip, random);
  return base;
}

/// Poles, single cells, walls with gaps, tight boxes, or one long wall, each inside a border.
inline CellWorld any_world(Random& random) {
  const double side =
      std::array{0.02, 0.05, 0.05, 0.1, 0.2}[static_cast<std::size_t>(pick(random, 5))];
  const double size = side < 0.03 ? 10.0 : 24.0, edge = 0.5 * size - 2.0 * side;
  CellWorld world(size, side);
  const auto place = [&] { return uniform(random, -0.48 * size, 0.48 * size); };
  const auto border = [&](double x, double y) { return std::max(std::abs(x), std::abs(y)) > edge; };
  const int kind = pick(random, 5);
  std::vector<std::array<double, 3>> discs;
  const int count = kind == 0 ? 60 : kind == 1 ? 120 : 0;
  for (int i = 0; i < count; ++i)
    discs.push_back({place(), place(), kind == 1 ? 0.0 : uniform(random, 0.05, 0.5)});
  const double angle = uniform(random, 0.0, 3.0), c = std::cos(angle), s = std::sin(angle);
  const double half_corridor = uniform(random, 0.3, 1.2), half_door = uniform(random, 0.3, 0.7);
  const double box = uniform(random, 0.7, 2.5);
  const int half = static_cast<int>(0.5 * size / side);
  for (int iy = -half; iy < half; ++iy)
    for (int ix = -half; ix < half; ++ix) {
      const double x = (ix + 0.5) * side, y = (iy + 0.5) * side;
      const double along = c * x + s * y, across = -s * x + c * y;
      bool occupied = border(x, y);
      if (kind == 2)  // corridors along `angle` with doors
        occupied |= std::abs(std::fmod(std::abs(across), 2.0 * half_corridor) - half_corridor) <
                        std::max(0.05, 0.75 * side) &&
                    std::fmod(std::abs(along), 5.0) > 2.0 * half_door;
      if (kind == 3)  // boxes with an open side here and there
        occupied |= (std::fmod(std::abs(x), box) < side && std::fmod(std::abs(y), 3.0) > 0.8) ||
                    (std::fmod(std::abs(y), box) < side && std::fmod(std::abs(x), 3.0) > 0.8);
      if (kind == 4) occupied |= std::abs(across) < std::max(0.05, 0.75 * side);
      if (occupied) world.add(ix, iy);
    }
  for (const auto& [cx, cy, r] : discs) {
    const int reach = static_cast<int>(r / side) + 1;
    const int mx = static_cast<int>(std::floor(cx / side)),
              my = static_cast<int>(std::floor(cy / side));
    for (int iy = my - reach; iy <= my + reach; ++iy)
      for (int ix = mx - reach; ix <= mx + reach; ++ix)
        if ((ix == mx && iy == my) ||
            std::hypot((ix + 0.5) * side - cx, (iy + 0.5) * side - cy) < r)
          if (std::max(std::abs(ix), std::abs(iy)) < half - 1) world.add(ix, iy);
  }
  world.sort_into_buckets();
  return world;
}

/// The filter with a base that has worst-case errors within its bounds, or beyond them.
class Loop {
 public:
  Loop(const SafetyFilterParams& params, const RobotParams& robot, const CellWorld& world,
       const Beyond& beyond, Random& random)
      : params_{params},
        robot_{robot},
        beyond_{beyond},
        random_{random},
        filter_{params, robot},
        base_{robot, any_behaviour(robot, params, beyond, random), world, random},
        age_kind_{pick(random, 4)} {
    filter_.on_map(world.as_static_map());
  }

  void start_at(const Placement& at) {
    base_.start_at(at);
    lost_ = 0;
    measured_.reset();
    errors_fresh_ = pick(random_, 2) == 0;
    draw_errors();
    steady_age_ = fraction(random_);
  }

  /// One control period of length `period`: measures (late, or not at all for a while), filters and
  /// sends.
  void tick(const Twist2& command, double period) {
    const double wait = fraction(random_) * 0.4 * period;
    base_.advance_to(now_ + period - wait);
    if (lost_ > 0) --lost_;
    if (lost_ == 0) measure(now_ + period - wait);
    if (lost_ == 0 && pick(random_, 25) == 0) lost_ = 1 + pick(random_, 6);
    base_.advance_to(now_ + period);
    now_ += period;
    filter_.on_command(command, now_);
    const Filtered out = filter_.update(measured_, now_);
    base_.command(out.twist.v, out.twist.w);
  }
  void be_silent(double duration) {
    now_ += duration;
    base_.advance_to(now_);
  }

  [[nodiscard]] const Base& base() const { return base_; }
  [[nodiscard]] double now() const { return now_; }

 private:
  void measure(double t) {
    if (errors_fresh_) draw_errors();
    const double age =
        beyond_.delay * robot_.sensor_delay *
        std::array{0.0, 1.0, steady_age_, fraction(random_)}[static_cast<std::size_t>(age_kind_)];
    const Base::State& state = base_.ago(age);
    measured_ = RobotState{
        {state.at.x + error_x_, state.at.y + error_y_, state.at.heading + error_heading_},
        {state.v, state.w},
        t,
        Pose2{state.odometry.x, state.odometry.y, state.odometry.heading}};
  }
  void draw_errors() {
    const double angle = uniform(random_, -std::numbers::pi, std::numbers::pi);
    const double size = beyond_.pose_error * fraction(random_) * params_.position_error;
    error_x_ = size * std::cos(angle);
    error_y_ = size * std::sin(angle);
    error_heading_ = beyond_.pose_error * uniform(random_, -1.0, 1.0) * params_.heading_error;
  }

  SafetyFilterParams params_;
  RobotParams robot_;
  Beyond beyond_;
  Random& random_;
  SafetyFilter filter_;
  Base base_;
  std::optional<RobotState> measured_;
  double now_ = 0.0, error_x_ = 0.0, error_y_ = 0.0, error_heading_ = 0.0, steady_age_ = 0.0;
  bool errors_fresh_ = false;
  int age_kind_;  // age of measurements: none, the bound, constant, or random for each
  int lost_ = 0;  // remaining ticks without odometry
};

inline std::optional<Placement> free_place(const Outline& outline, const CellWorld& world,
                                           double clearance, Random& random) {
  const double most = 0.45 * world.size();
  for (int attempt = 0; attempt < 300; ++attempt) {
    const Placement at{uniform(random, -most, most), uniform(random, -most, most),
                       uniform(random, -std::numbers::pi, std::numbers::pi)};
    if (clearance_bound(outline, at, world, clearance + 0.01) > clearance) return at;
  }
  return std::nullopt;
}

inline constexpr int kRolloutsPerScene = 6;
inline constexpr double kLongestRest = 25.0;  // [s] the robot must stand after this time

/// Pushes for up to `longest` seconds, or until the robot has hardly moved for 4 s. Then there is
/// no command, or no filter, until it stands.
inline void roll_out(Loop& loop, Attack& attack, const SafetyFilterParams& params, Random& random,
                     Tally& tally, double longest = 30.0) {
  const double period = params.control_period;
  const double most = pick(random, 2) ? std::min(3.0, longest) : longest;
  const double end = loop.now() + uniform(random, 0.3, most);
  double moved_to = loop.base().travel(), moved_at = loop.now();
  for (; loop.now() < end && loop.now() < moved_at + 4.0; ++tally.steps) {
    const Twist2 command = attack.command(loop.base().at(), loop.now());
    loop.tick(command, pick(random, 2) ? period : uniform(random, 0.4, 1.0) * period);
    if (loop.base().travel() < moved_to + 0.2) continue;
    moved_to = loop.base().travel();
    moved_at = loop.now();
  }
  if (params.survive_silence && pick(random, 2)) loop.be_silent(1.0);
  const double latest = loop.now() + kLongestRest;
  for (int i = 0; loop.now() < latest && (i < 3 || !loop.base().stands()); ++i, ++tally.steps)
    loop.tick({}, period);
  ++tally.rollouts;
  tally.unfinished += loop.base().stands() ? 0 : 1;
}

/// Adds what the base recorded over all rollouts of a scene.
inline void finish_scene(Tally& tally, const Loop& loop, unsigned seed) {
  tally.min_clearance = loop.base().min_clearance();
  tally.travel = loop.base().travel();
  if (tally.contacts > 0) tally.contact_seed = seed;
  tally.closest_seed = seed;
}

/// Runs kRolloutsPerScene rollouts with the world and the robot of that seed.
[[nodiscard]] inline Tally run_scene(unsigned seed, const Beyond& beyond = {}) {
  Tally tally;
  Random random(seed);
  const SafetyFilterParams params = any_filter(random);
  const RobotParams robot = any_robot(random);
  const CellWorld world = any_world(random);
  Loop loop(params, robot, world, beyond, random);
  const double clearance =
      0.02 + params.position_error + loop.base().radius() * params.heading_error;
  for (int i = 0; i < kRolloutsPerScene && tally.contacts == 0; ++i) {
    const auto start = free_place(loop.base().outline(), world, clearance, random);
    if (!start) break;
    loop.start_at(*start);
    Attack attack(static_cast<Plan>(pick(random, kPlans)), robot, world, random);
    roll_out(loop, attack, params, random, tally);
    tally.contacts += loop.base().touched() ? 1 : 0;
  }
  finish_scene(tally, loop, seed);
  return tally;
}

}  // namespace tandem::test
