// SPDX-License-Identifier: Apache-2.0
// Turns a joystick's axes and buttons into the person's twist and the leader pose.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/model/brief_push.hpp"
#include "tandem/model/reasons.hpp"
#include "tandem/model/robot.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Scaling of the stick; may change while someone drives. Defaults: Devalla 2020, appendix B, which
/// gives no number for the leash d_PR.
struct StickGains {
  double scale_linear = 0.8;
  double scale_angular = 0.8;
  double leader_scale_linear = 0.9;
  double leader_scale_angular = 0.9;
  double deadzone = 0.05;
  double leash = 1.2;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("scale_linear", scale_linear, Range{-5.0, 5.0}, "[m/s] speed at full stick");
    field("scale_angular", scale_angular, Range{-10.0, 10.0}, "[rad/s] turn rate at full stick");
    field("leader_scale_linear", leader_scale_linear, Range{-5.0, 5.0},
          "[m/s] speed of the leader at full stick");
    field("leader_scale_angular", leader_scale_angular, Range{-10.0, 10.0},
          "[rad/s] turn rate of the leader at full stick");
    field("deadzone", deadzone, Range{0.0, 0.9},
          "[1] fraction of the stick's travel that counts as rest");
    field("leash", leash, Range{0.1, 10.0}, "[m] maximum distance of the leader from the robot");
  }
};

/// Defaults: Devalla 2020, appendix B.
struct TeleopParams {
  int axis_linear = 1;
  int axis_angular = 0;
  int deadman_button = 0;
  int end_button = 1;
  double axis_range = 1.0;
  StickGains gains{};  ///< can be changed while it runs
  double joy_timeout = 0.12;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("axis_linear", axis_linear, Range{0, 31}, "index in Joy.axes of the forward axis");
    field("axis_angular", axis_angular, Range{0, 31}, "index in Joy.axes of the axis to the left");
    field("deadman_button", deadman_button, Range{-1, 63},
          "button that must be held to drive; -1: none");
    field("end_button", end_button, Range{-1, 63}, "button that ends the drive; -1: none");
    field("axis_range", axis_range, Range{1e-3, 1e6},
          "[1] value of Joy.axes at full stick; an axis that exceeds it by more than 5 % is "
          "rejected");
    gains.visit(field);
    field("joy_timeout", joy_timeout, Range{0.02, 5.0},
          "[s] when joy, or another publisher of cmd_vel_user, has been silent for this long, the "
          "leader ends and another publisher may drive");
  }
};

/// State of a joystick: axes in [−1, 1], buttons pressed or not.
struct Stick {
  double linear = 0.0, angular = 0.0;  ///< [1], forward and to the left
  bool deadman = false, end = false;   ///< held; end of the drive pressed
};

/// Reads the axes and buttons that the parameters name. An axis that is missing, not finite or
/// beyond `axis_range` counts as at rest, a missing dead-man button as released.
[[nodiscard]] Stick read_stick(std::span<const float> axes, std::span<const int> buttons,
                               const TeleopParams& params);

/// Result of checking a joy message.
struct JoyCheck {
  bool at_rest = false;       ///< an axis is present, and all present ones are in the dead zone
  bool beyond_range = false;  ///< an axis is; its scale is unknown, so it may not drive
  std::string trouble;        ///< why the stick's position is unknown; empty: it is known
  std::string remark;         ///< a minor defect; empty: none
};

/// Checks the axes and buttons that the parameters name.
[[nodiscard]] JoyCheck check_joy(std::span<const float> axes, std::span<const int> buttons,
                                 const TeleopParams& params);

/// Axes and buttons of a sensor_msgs/Joy.
struct JoyValues {
  std::vector<float> axes;   ///< in [−1, 1]
  std::vector<int> buttons;  ///< 1: pressed
};

/// Inverse of read_stick, for our own devices (keys, on-screen stick): axes and buttons with which
/// teleop drives forward and to the left for positive `stick`, whatever its parameters.
[[nodiscard]] JoyValues joy_values(const Stick& stick, const TeleopParams& params);

/// Output for one sample of the joystick.
struct Intent {
  Twist2 twist;               ///< the person's command
  std::optional<Pose2> X_ML;  ///< pose of the leader L, if the robot's pose is known
};

/// Trouble of a stick that has not been seen at rest, see RestCheck.
inline constexpr const char* kNotAtRest = text_of(Reason::kStickMoved);

/// Converts the stick into a twist and drives the leader: a virtual robot that the stick moves and
/// that never gets farther from the robot than the leash (Devalla 2020, §3.1.4).
///
/// Additions to the thesis:
///
/// * Reversing the stick (forward to backward or vice versa) returns the leader to the robot
///   immediately.
/// * A stick at rest moves the leader to the point where the robot stops if it brakes now; after a
///   pulse only if the rest is long (BriefPush).
/// * A stick that only turns, while the robot stands, moves the leader to the robot.
/// * The leader is no faster than its robot.
class Teleop {
 public:
  /// Without `robot`, the leader is as fast as the stick asks for, and a stick at rest moves it to
  /// the robot's current position.
  explicit Teleop(const TeleopParams& params, const std::optional<RobotParams>& robot = {});

  /// Throws std::invalid_argument, having changed nothing, on gains out of range.
  void set_gains(const StickGains& gains);

  /// Set while the planner passes the person's own command through (PlannerStatus.source
  /// `yielded`): the leader then stays near the robot, so the person steers what they see move.
  void keep_leader_near(bool near) { near_ = near; }

  /// `X_MB`, `measured`: the robot's pose and twist, if known. `t` [s]. Returns no intent while the
  /// dead-man is released, except a single zero at the moment of release; the leader then returns
  /// to the robot.
  ///
  /// The zero reports that the stick was let go, so that a robot may start again after an emergency
  /// stop. A joystick that falls silent may still be held: no zero is sent for it, and the silence
  /// stops the robot. The leader returns to the robot in this case, too.
  [[nodiscard]] std::optional<Intent> on_stick(const Stick& stick, const std::optional<Pose2>& X_MB,
                                               double t, const Twist2& measured = {});

  /// Takes a command from another publisher of cmd_vel_user (a program, another teleoperation).
  /// Returns the leader that it drives; nullopt while a stick is held or the robot's pose is
  /// unknown.
  [[nodiscard]] std::optional<Pose2> on_twist(const Twist2& twist, const std::optional<Pose2>& X_MB,
                                              double t, const Twist2& measured = {});

 private:
  enum class Hand { kNone, kStick, kTwist };
  struct Steering {
    Twist2 twist;     // desired twist of the leader
    double push;      // [1] deflection of the stick along the linear axis
    Twist2 measured;  // twist of the robot
    bool rests = false;
  };

  void lead(Hand hand, const Steering& steering, const std::optional<Pose2>& X_MB, double t);
  void call_leader_back(double push, const Pose2& X_MB);
  void drive_leader(const Steering& steering, const Pose2& X_MB, double dt);
  [[nodiscard]] Pose2 driven(const Pose2& X_ML, const Steering& steering, const Pose2& X_MB,
                             double dt) const;
  [[nodiscard]] Pose2 braking_point(const Pose2& X_MB, const Twist2& measured) const;

  TeleopParams params_;
  std::optional<RobotParams> robot_;
  BriefPush push_;
  bool held_ = false;
  Stamped<bool> steered_;  // a stick controlled the leader
  Stamped<Hand> hand_;     // what drove the leader last
  std::optional<Pose2> X_ML_;
  bool near_ = false;    // see keep_leader_near()
  double pushed_ = 0.0;  // [1] last strong push; positive is forward
};

}  // namespace tandem
