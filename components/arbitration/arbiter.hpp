// SPDX-License-Identifier: Apache-2.0
// Selects the command in force among those of the person, the planner and an outside autonomy, and
// gives the reason why the robot moves or stands.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tandem/arbitration/emergency_stop.hpp"
#include "tandem/arbitration/handover.hpp"
#include "tandem/arbitration/performance.hpp"
#include "tandem/config/params.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Who may drive. kManual: the person alone. kShared: the planner on the person's behalf. kBlend: a
/// mixture of both. kAdaptive: a mixture in which the planner's share follows how well the person
/// drives. kAutonomous: the outside autonomy, else the planner with its own goal; the person takes
/// over by steering.
enum class Policy { kManual, kShared, kBlend, kAdaptive, kAutonomous };

/// Whose command is passed on.
enum class Source { kNone, kUser, kShared, kBlend, kNav };

/// Reason for a decision.
enum class ArbitrationReason {
  kFollowsSource,
  kHandover,       ///< authority has just changed: ramping up to the new command
  kUserTakesOver,  ///< autonomous, but the person steers
  kEmergencyStop,
  kLetGoFirst,  ///< emergency stop released, but the person has not let go of the stick yet
  kSteerFirst,  ///< the person has let go and the stick is still at rest
  kUserSilent,
  kSharedSilent,
  kAllSilent,
  kClockSilent,  ///< /clock is silent, so the age of a command is unknown
};

/// The names of the policies, in the order of the enumeration.
[[nodiscard]] const std::vector<std::string>& policies();

/// The policy as parameters and messages write it.
[[nodiscard]] const char* name(Policy policy);
/// The source as messages write it.
[[nodiscard]] const char* name(Source source);
/// The reason in short, for logs and tables.
[[nodiscard]] const char* name(ArbitrationReason reason);

/// Throws std::invalid_argument, listing the policies, if `text` is not one of them.
[[nodiscard]] Policy policy_from(const std::string& text);

/// Weights of policy `blend`; may change while the robot drives.
struct BlendParams {
  double clearance = 0.8;
  double disagreement = 0.5;
  double min = 0.1;
  double rate = 4.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("blend_clearance", clearance, Range{0.01, 10.0},
          "[m] clearance below which danger begins to shift authority to the planner");
    field("blend_disagreement", disagreement, Range{0.01, 10.0},
          "[m/s, rad/s] difference of the two commands that gives the planner full authority");
    field("blend_min", min, Range{0.0, 1.0}, "[1] minimum authority of the planner");
    field("blend_rate", rate, Range{0.1, 100.0}, "[1/s] maximum rate of change of authority");
  }
};

/// Policy, time-outs and hand-over of the arbiter.
struct ArbiterParams {
  std::string policy = "shared";
  double user_timeout = 0.11;
  double shared_timeout = 0.12;
  double nav_timeout = 0.5;
  double handover_time = 0.3;
  double takeover_threshold = 0.05;
  BlendParams blend{};        ///< of policy blend
  AdaptiveParams adaptive{};  ///< of policy adaptive

  template <class Visitor>
  void visit(Visitor&& field) {
    field("policy", policy, OneOf{policies()},
          "policy at start; the service ~/set_policy changes it");
    field("user_timeout", user_timeout, Range{0.02, 5.0},
          "[s] the person's command ends after this long without a message");
    field("shared_timeout", shared_timeout, Range{0.02, 5.0},
          "[s] the planner's command ends after this long without a message");
    field("nav_timeout", nav_timeout, Range{0.02, 5.0},
          "[s] autonomy ends after this long without a command from it");
    field("handover_time", handover_time, Range{0.0, 5.0},
          "[s] maximum duration of a ramp up when authority changes; slowing down is immediate");
    field("takeover_threshold", takeover_threshold, Range{0.0, 1.0},
          "[m/s, rad/s] a person's command above this takes over from autonomy");
    blend.visit(field);
    adaptive.visit(field);
  }
};

/// The command to pass on, whose it is and why.
struct Decision {
  Twist2 command;                                            ///< zero if nobody may drive
  Source source = Source::kNone;                             ///< kNone: nobody may drive
  ArbitrationReason reason = ArbitrationReason::kAllSilent;  ///< why this source
  double alpha = 0.0;        ///< the planner's share of the command, 0 … 1
  double performance = 1.0;  ///< of the person, 0 … 1, as measured by policy adaptive
};

/// Decides whose command is passed on. Times are seconds on one monotonic clock; the age of a
/// command is counted from its arrival. Never throws after construction, except where stated. A
/// non-finite command is ignored; finite commands give a finite decision.
class Arbiter {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  explicit Arbiter(const ArbiterParams& params);

  /// Throws std::invalid_argument, having changed nothing, on parameters out of range.
  void set_blend(const BlendParams& blend);

  /// Takes the person's command, which arrived at time t [s].
  void on_user(const Twist2& twist, double t);
  /// Takes the planner's command, which arrived at time t [s].
  void on_shared(const Twist2& twist, double t);
  /// Takes the command of another autonomy, such as Nav2's, which arrived at time t [s].
  void on_nav(const Twist2& twist, double t);
  /// Distance from the robot to the nearest obstacle [m]; policy blend uses it.
  void on_clearance(double clearance, double t);
  /// Why a held stick does not move the robot; empty: nothing prevents it.
  void on_stick(std::string trouble, double t) { stick_ = {std::move(trouble), t}; }
  /// Why the planner has no plan; empty: it has one.
  void on_planner(std::string trouble, double t) { planner_ = {std::move(trouble), t}; }
  /// Why the safety filter passes nothing; empty: it passes something.
  void on_filter(std::string trouble, double t) { filter_ = {std::move(trouble), t}; }

  /// Latches; only release_emergency_stop() releases it, and only if the last signal was `false`.
  /// Pressing ends policy kAutonomous (kShared follows). After the release the robot stands until
  /// the person has let go of the stick for 1 s (or `user_timeout` if longer) and then steers, or
  /// until kAutonomous is chosen. A stick that falls silent does not count as let go: see
  /// EmergencyStop.
  void on_emergency_stop(bool pressed);
  /// Releases the stop if the last signal was `false`. Returns whether it is released now.
  [[nodiscard]] bool release_emergency_stop() { return stop_.release(); }
  /// Whether the emergency stop is latched.
  [[nodiscard]] bool emergency_stopped() const { return stop_.latched(); }

  /// Returns false, changing nothing, for kAutonomous while the emergency stop is latched: the
  /// release would start the robot.
  [[nodiscard]] bool set_policy(Policy policy);
  /// The policy in force.
  [[nodiscard]] Policy policy() const { return policy_; }

  /// Call after the clock jumped back to `now`: discards all inputs. Policy and emergency stop
  /// stay.
  void on_time_jump(double now);

  /// The decision for `now` [s], which must not decrease. Call it once per control period:
  /// hand-over and blending go on from the last decision.
  [[nodiscard]] Decision decide(double now);
  /// Why the robot moves or stands after `decision`: the first that applies of
  ///
  /// * the reason it is stopped here, unless it is that nobody steers,
  /// * if nobody steers: why the stick of a person who tries to does not move the robot,
  /// * why the safety filter would stop any command,
  /// * that nobody steers,
  /// * the planner's trouble, if its command is in force,
  /// * the decision's own reason.
  [[nodiscard]] std::string why(const Decision& decision, double now) const;
  /// Whether a person is at the stick: the last user command is fresh.
  [[nodiscard]] bool user_is_fresh(double now) const {
    return user_.fresh(now, params_.user_timeout);
  }
  /// Topics of the inputs that were received once and are silent now.
  [[nodiscard]] std::vector<std::string> silent_sources(double now) const;

 private:
  [[nodiscard]] std::string trouble_of_filter(double now) const;
  [[nodiscard]] Decision choose(double now);
  [[nodiscard]] Decision choose_by_policy(double now);
  [[nodiscard]] bool steers(double now) const;
  [[nodiscard]] Decision choose_autonomous(double now) const;
  [[nodiscard]] Decision blend(double now, double least, double disagreement);
  [[nodiscard]] Decision adapt(double now);
  [[nodiscard]] Decision ramp(Decision decision, double now);

  ArbiterParams params_;
  Policy policy_;
  Stamped<Twist2> user_, shared_, nav_;
  Stamped<std::string> stick_, planner_, filter_;  // what troubles them; empty: nothing
  Stamped<double> clearance_;                      // [m]
  Performance performance_;
  EmergencyStop stop_;
  Handover handover_;

  Decision last_;
  double last_time_ = 0.0;
  double alpha_ = 0.0;
};

}  // namespace tandem
