// SPDX-License-Identifier: Apache-2.0
// Turns a joystick's axes and buttons into the person's twist and leader.
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

namespace tandem {

/// How the stick feels: may change while someone drives. Defaults: Devalla 2020, appendix B; its
/// leash d_PR has no number there.
struct StickGains {
  double scale_linear = 0.8;
  double scale_angular = 0.8;
  double leader_scale_linear = 0.9;
  double leader_scale_angular = 0.9;
  double deadzone = 0.05;
  double leash = 1.2;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("scale_linear", scale_linear, Range{-5.0, 5.0}, "[m/s] at full stick");
    field("scale_angular", scale_angular, Range{-10.0, 10.0}, "[rad/s] at full stick");
    field("leader_scale_linear", leader_scale_linear, Range{-5.0, 5.0}, "[m/s] leader, full stick");
    field("leader_scale_angular", leader_scale_angular, Range{-10.0, 10.0},
          "[rad/s] leader, full stick");
    field("deadzone", deadzone, Range{0.0, 0.9}, "[1] part of the stick's way that is rest");
    field("leash", leash, Range{0.1, 10.0}, "[m] farthest that the leader gets from the robot");
  }
};

/// Defaults: Devalla 2020, appendix B.
struct TeleopParams {
  int axis_linear = 1;
  int axis_angular = 0;
  int deadman_button = 0;
  int end_button = 1;
  double axis_range = 1.0;
  StickGains gains{};
  double joy_timeout = 0.12;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("axis_linear", axis_linear, Range{0, 31}, "index in Joy.axes that means forward");
    field("axis_angular", axis_angular, Range{0, 31}, "index in Joy.axes that means left");
    field("deadman_button", deadman_button, Range{-1, 63}, "held to drive; -1: none");
    field("end_button", end_button, Range{-1, 63}, "ends the drive; -1: none");
    field("axis_range", axis_range, Range{1e-3, 1e6},
          "[1] what Joy.axes are at full stick; an axis that exceeds it by more than 5 % drives "
          "nothing");
    gains.visit(field);
    field("joy_timeout", joy_timeout, Range{0.02, 5.0},
          "[s] silence of joy, or of another writer of cmd_vel_user, that ends the leader and lets "
          "another one drive");
  }
};

/// What a joystick says: axes in [−1, 1], buttons pressed or not.
struct Stick {
  double linear = 0.0, angular = 0.0;
  bool deadman = false, end = false;
};

/// Reads the axes and buttons that the parameters name; one that is missing, not finite or beyond
/// `axis_range` counts as at rest (a missing dead-man button as released).
[[nodiscard]] Stick read_stick(std::span<const float> axes, std::span<const int> buttons,
                               const TeleopParams& params);

/// What a message of joy says of the device.
struct JoyCheck {
  bool at_rest = false;       ///< some axis is there, and each that is lies inside the dead zone
  bool beyond_range = false;  ///< an axis is: its scale is not known, so the stick may not drive
  std::string trouble;        ///< why the message does not say where the stick is; empty: it does
  std::string remark;         ///< what else it lacks; empty: nothing
};

/// Checks the axes and buttons that the parameters name.
[[nodiscard]] JoyCheck check_joy(std::span<const float> axes, std::span<const int> buttons,
                                 const TeleopParams& params);

struct JoyValues {
  std::vector<float> axes;
  std::vector<int> buttons;
};

/// The inverse, for devices that are ours (keys, a stick on a screen): axes and buttons with which
/// teleop drives forward and to the left for positive `stick`, whatever its parameters.
[[nodiscard]] JoyValues joy_values(const Stick& stick, const TeleopParams& params);

/// What goes out after a sample of the joystick.
struct Intent {
  Twist2 twist;               ///< the person's command
  std::optional<Pose2> X_ML;  ///< the leader L, if the robot's pose is known
};

/// Why a stick drives nothing that was not seen at rest, see RestCheck.
inline constexpr const char* kNotAtRest = text_of(Reason::kStickMoved);

/// The person at the stick: dead-man, scaling, and the leader, a virtual robot that the stick
/// drives and that never gets farther from the robot than the leash (Devalla 2020, §3.1.4). Not in
/// the thesis: who throws the stick from forward to backward, or back, finds the leader beside the
/// robot at once; a stick at rest brings it to where the robot comes to rest if it brakes now,
/// after a pulse only when the rest is long (BriefPush); a stick that only turns, beside a robot
/// that stands, brings it to the robot; and a leader is no faster than its robot.
class Teleop {
 public:
  /// Without the robot's limits the leader is as fast as the stick asks for, and a stick at rest
  /// brings it to where the robot is.
  explicit Teleop(const TeleopParams& params, const std::optional<RobotParams>& robot = {});

  /// Throws std::invalid_argument, having changed nothing, on gains out of range.
  void set_gains(const StickGains& gains);

  /// While the planner hands the person's own command on (PlannerStatus.source `yielded`), the
  /// leader stays beside the robot: the person steers what they see move.
  void keep_leader_near(bool near) { near_ = near; }

  /// `X_MB`, `measured`: where the robot is and how it moves, if that is known. No intent while the
  /// dead-man is released, but for one zero at the moment of release; the leader then returns to
  /// the robot.
  ///
  /// A zero tells that the stick was let go of, so that a robot may start again after an emergency
  /// stop. A joystick that falls silent may still be held: it gets no zero, and silence stops the
  /// robot. The leader returns to the robot in this case, too.
  [[nodiscard]] std::optional<Intent> on_stick(const Stick& stick, const std::optional<Pose2>& X_MB,
                                               double t, const Twist2& measured = {});

  /// A command from another publisher of cmd_vel_user (a program, another teleoperation). Returns
  /// the leader that it drives; nothing while a stick is held or the robot's pose is unknown.
  [[nodiscard]] std::optional<Pose2> on_twist(const Twist2& twist, const std::optional<Pose2>& X_MB,
                                              double t, const Twist2& measured = {});

 private:
  enum class Hand { kNone, kStick, kTwist };
  struct Wish {
    Twist2 twist;     // of the leader
    double push;      // [1] of the stick's way
    Twist2 measured;  // what the robot does
    bool rests = false;
  };

  [[nodiscard]] bool is_recent(double t, double now) const {
    return 0.0 <= now - t && now - t <= params_.joy_timeout;  // not if the clock was set back
  }
  void lead(Hand hand, const Wish& wish, const std::optional<Pose2>& X_MB, double t);
  void call_leader_back(double push, const Pose2& X_MB);
  void drive_leader(const Wish& wish, const Pose2& X_MB, double dt);
  [[nodiscard]] Pose2 driven(const Pose2& X_ML, const Wish& wish, const Pose2& X_MB,
                             double dt) const;
  [[nodiscard]] Pose2 braking_point(const Pose2& X_MB, const Twist2& measured) const;

  TeleopParams params_;
  std::optional<RobotParams> robot_;
  BriefPush push_;
  bool held_ = false;
  std::optional<double> steered_;  // [s] when a stick last had the say over the leader
  Hand hand_ = Hand::kNone;        // that drives the leader
  double last_ = 0.0;              // [s] when it last did
  std::optional<Pose2> X_ML_;
  bool near_ = false;    // keep_leader_near()
  double pushed_ = 0.0;  // [1] the last push that was strong, forward or backward
};

}  // namespace tandem
