// SPDX-License-Identifier: Apache-2.0
// Limits a command so that it cannot end in contact, given the robot's state, the map and tracked
// people.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/localization.hpp"
#include "tandem/model/robot.hpp"
#include "tandem/model/twist_check.hpp"
#include "tandem/safety_filter/clearance_check.hpp"
#include "tandem/safety_filter/people_check.hpp"
#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

class UnseenCheck;

/// The margin is an error budget (defaults, MiR 100, circumradius R = 0.56 m):
///
///   position_error + R heading_error     localiser                      0.010 + 0.006 m
///   reserve                              unmodelled errors              0.005 m
///   kCheckSpacing / 2                    between two checked poses      0.004 m
///   hard margin                                                         0.025 m     (1)
///   + band                               where fast approach ends       0.010 m
///   + deviation                          grows with the distance to rest, deviation.hpp (3)    (2)
///
/// Driving straight over the distance s, with L the wheel separation, the deviation is
///
///   (slip (1 + 2 R / L) + heading_error) s + slip s² / L.
///
/// A MiR passes a door 0.80 m wide with 0.11 m on either side.
struct SafetyFilterParams {
  bool enforce = true;
  double arbitrated_timeout = 0.1;
  double state_timeout = 0.2;
  double control_period = 0.05;
  bool survive_silence = true;
  double position_error = 0.01;
  double heading_error = 0.01;
  double reserve = 0.005;
  double band = 0.01;
  double manoeuvre_speed = 0.1;
  double slip = 0.02;
  double brake_spread = 1.5;
  double unseen_speed = 0.15;
  double jump_distance = 0.2;
  double jump_angle = 0.3;
  double jump_rest = 1.0;
  double odom_resolution = 0.01;
  PeopleParams people{};  ///< of people nearby

  template <class Visitor>
  void visit(Visitor&& field) {
    field("enforce", enforce, "false: pass every command unchanged and only report; for studies");
    field("arbitrated_timeout", arbitrated_timeout, Range{0.02, 5.0},
          "[s] the robot stops when cmd_vel_arbitrated has been silent for this long");
    field("state_timeout", state_timeout, Range{0.02, 5.0},
          "[s] the robot stops when its state is older than this");
    field("control_period", control_period, Range{0.002, 1.0},
          "[s] maximum time from one output to the next");
    field("survive_silence", survive_silence,
          "true: a command is assumed to act until the base itself stops after base_timeout, so "
          "that the robot stops before contact even if this filter or its messages are lost");
    field("position_error", position_error, Range{0.0, 0.5},
          "[m] upper bound on the pose's position error");
    field("heading_error", heading_error, Range{0.0, 0.5},
          "[rad] upper bound on the pose's heading error");
    field("reserve", reserve, Range{0.0, 0.5}, "[m] added to the margin");
    field("band", band, Range{0.0, 0.5},
          "[m] distance beyond the margin at which the robot stops approaching …");
    field("manoeuvre_speed", manoeuvre_speed, Range{0.0, 1.0},
          "[m/s] … unless the command moves the outline's fastest point no faster than this");
    field("slip", slip, Range{0.0, 0.3},
          "[1] upper bound on the relative error of a wheel's travel");
    field("brake_spread", brake_spread, Range{1.0, 10.0},
          "[1] actual braking is at most this factor times the robot's a_brake, alpha_brake");
    field("unseen_speed", unseen_speed, Range{0.0, 10.0},
          "[m/s] with map_source local, and with both outside of the static map: speed limit of "
          "every point of the outline over ground that no beam has covered within "
          "octomap_builder's coverage_timeout; 0: such ground is not entered");
    field("jump_distance", jump_distance, Range{0.02, 10.0},
          "[m] a pose this far from the wheel odometry's prediction is rejected at first …");
    field("jump_angle", jump_angle, Range{0.02, 4.0}, "[rad] … as is one rotated by this …");
    field("jump_rest", jump_rest, Range{0.0, 60.0},
          "[s] … and accepted only after standing still for this long");
    field("odom_resolution", odom_resolution, Range{0.0, 0.5},
          "[m, rad] resolution of odometry's pose; larger differences between its twist and its "
          "poses are treated as a fault");
    people.visit(field);
  }
};

/// Why the filter returned this command. From kNoCommand on, the robot does not drive at all.
enum class FilterReason {
  kClear,           ///< passed unchanged
  kSlowed,          ///< a fraction of the command, on the same arc
  kDeflected,       ///< the arc is blocked; a fraction of its turn or of its forward part passed
  kBackingOut,      ///< inside the margin; the command does not reduce clearance
  kUnseen,          ///< all or part of the command is too fast for unseen ground
  kStopped,         ///< no part of the command is safe
  kStoppedInDoubt,  ///< no part is safe at the speeds that odometry's twist or poses allow
  kNoCommand,       ///< no command received, or it timed out
  kNotFinite,       ///< the command is not finite
  kNotLocalized,
  kPoseJumped,  ///< the pose contradicts the wheel odometry
  kTooFast,     ///< odometry reports a speed beyond the robot's limits
  kNoMap,
  kNoPeople,     ///< people are tracked, but no recent list arrived
  kClockSilent,  ///< set by the node: /clock is silent, so ages are unknown
};

/// The reason in short, for logs and tables.
[[nodiscard]] const char* name(FilterReason reason);

/// The command that may be sent, and what was changed.
struct Filtered {
  Twist2 twist;      ///< to send now
  Twist2 requested;  ///< the command received
  Twist2 safe;       ///< the safe part of it; equals `twist` while enforcing
  FilterReason reason = FilterReason::kNoCommand;  ///< why it was changed, or that it was not
  double scale = 0.0;  ///< fraction of the requested command that is safe
  /// Clearance of the outline at the measured pose [m], at most 1; NaN where it was not computed.
  double clearance = std::numeric_limits<double>::quiet_NaN();
  bool refused = false;  ///< the command would move the robot, and no part of it passed
  bool twist_contradicted =
      false;  ///< odometry's twist contradicts its poses; the filter assumes the worse
};

/// Last check before the wheels; trusts no upstream node.
///
/// A command passes only if, acting for one control period (or, with survive_silence, until the
/// base's own timeout) and then braked, the robot stops before contact plus margin, for all delays,
/// ages of odometry, lags and braking within their bounds. Otherwise the largest safe fraction
/// passes, else zero. Call update() on every command and at least every control_period, and send
/// what it returns. By induction, a robot that starts safe in a static world stays safe, and one
/// that tracks people touches nobody while it moves.
///
/// Inside the margin only motion that does not reduce clearance passes. Between the hard margin and
/// the end of the band the robot may approach down to the hard margin, as a tail that swings out
/// must. From beyond the band only a slow manoeuvre may, so that a person who pushes against a wall
/// keeps the band for the way out. Unseen ground, if given, adds a speed limit: no motion may reach
/// it faster than unseen_speed. Times are seconds on one monotonic clock.
class SafetyFilter {
 public:
  /// Throws std::invalid_argument on parameters out of range, and on survive_silence with a base
  /// that never stops by itself (base_timeout 0).
  SafetyFilter(const SafetyFilterParams& params, const RobotParams& robot);

  /// Sets the command to be checked, which arrived at time t [s].
  void on_command(const Twist2& twist, double t);
  /// Sets the map and, as obstacles, the ground that no beam has covered; null: all ground is seen.
  void on_map(std::shared_ptr<const StaticMap> map,
              std::shared_ptr<const StaticMap> unseen = nullptr) {
    map_ = std::move(map);
    unseen_ = std::move(unseen);
  }
  /// Sets the people nearby, from the list that arrived at time t.
  void on_people(std::vector<Obstacle> people, double t) { people_ = {std::move(people), t}; }

  /// Takes the robot's state. Call it on every odometry message and every transform, also between
  /// two commands: this is how two alternating pose sources are detected.
  void on_state(const RobotState& state, double now);

  /// Call after the clock jumped back to `now`: discards all times. The last command sent still
  /// acts, and a jumped pose is not believed for another `jump_rest`.
  void on_time_jump(double now);

  /// Returns the command to send now and records it as sent. `state`: Localization::state(now).
  [[nodiscard]] Filtered update(const std::optional<RobotState>& state, double now);

  /// Returns zero and records it as sent, for a reason that only the node knows.
  [[nodiscard]] Filtered stop(FilterReason reason, double now);

  /// The check alone: the safe part of `command` on this map and the unseen ground given to on_map,
  /// given the commands already sent. `reason` and `scale` describe the result.
  [[nodiscard]] Filtered filter(const Twist2& command, const RobotState& state,
                                const StaticMap& map, double now) const;

  /// Clearance below which only motion that does not reduce it passes, (1) [m].
  [[nodiscard]] double hard_margin() const { return hard_margin_; }
  /// The parameters in force.
  [[nodiscard]] const SafetyFilterParams& params() const { return params_; }

 private:
  struct Scene;

  [[nodiscard]] Filtered decide(const std::optional<RobotState>& state, double now) const;
  [[nodiscard]] Scene look_at(const RobotState& state, const StaticMap& map, const Twist2& wanted,
                              double now) const;
  [[nodiscard]] double required_level(const Twist2& wanted, double clearance) const;
  [[nodiscard]] bool is_too_fast(const Twist2& measured) const;
  [[nodiscard]] bool is_safe(const Twist2& command, const Scene& scene) const;
  [[nodiscard]] bool is_safe_at_any_age(MotionStart start, int steps, const Scene& scene) const;
  [[nodiscard]] bool are_walls_far(double path, double turn, const Scene& scene) const;
  [[nodiscard]] bool is_unseen_far(double path, double turn, const Scene& scene) const;
  [[nodiscard]] bool is_safe_from(const MotionStart& start, const Scene& scene) const;
  [[nodiscard]] double largest_safe_scale(const Twist2& command, const Scene& scene) const;
  void reduce(Filtered& out, const Twist2& command, const Scene& scene) const;
  void reduce_to_safe(Filtered& out, const Twist2& command, const Scene& scene) const;
  void slow_down_for_unseen(Filtered& out, const Twist2& command, const Scene& scene) const;
  [[nodiscard]] bool is_unseen_in_the_way(const Twist2& command, double safe_scale,
                                          const Scene& scene) const;
  void remember(const Twist2& twist, double now);

  SafetyFilterParams params_;
  RobotParams robot_;
  BoundedFootprint body_;
  double hard_margin_, hold_;
  StoppingBounds bounds_;
  DriftBounds drift_;
  std::optional<PeopleCheck> people_check_;
  std::shared_ptr<const UnseenCheck> unseen_check_;
  std::shared_ptr<const StaticMap> map_, unseen_;
  PeopleSeen people_;
  TwistCheck twist_check_;
  Stamped<Twist2> command_;
  std::vector<Stamped<Twist2>> sent_;  // oldest first
  std::optional<RobotState> last_state_;
  double jumped_until_;  // [s]
};

}  // namespace tandem
