// SPDX-License-Identifier: Apache-2.0
// Every reason that a status message gives: why the robot drives as it does, why it stands or a
// node is in trouble, and the remedy for that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tandem {

/// Reasons that nodes report; those with a remedy in the order of the data flow: sensors first, the
/// base last. Their numbers are published and recorded (tandem_msgs/ReasonCode): a new reason goes
/// to the end, and no number is used again.
enum class Reason : std::uint8_t {
  kNone,   ///< no reason is given: the text is empty
  kOther,  ///< a text that is not in the table
  // Commands pass, and plans are made.
  kClear,
  kSlowed,
  kDeflected,
  kBackingOut,
  kFollowsSource,
  kHandover,
  kUserTakesOver,
  kPlanOptimal,
  kPlanAcceptable,
  kArcChosen,
  // The robot stands, or a node is in trouble.
  kNothingSensed,
  kSensorMissing,
  kSensorSilent,
  kSensorBlind,
  kSensorFrozen,
  kSensorRefused,
  kSensorUnplaced,
  kSensorInWorld,
  kSensorUnlocalized,
  kSensorUntimely,
  kSensorTooFar,
  kFewBeams,
  kSensingSilent,
  kLocalMapSilent,
  kNoMap,
  kNoMapYet,
  kOtherFrame,
  kMapNotPlaced,
  kMapMoved,
  kNotLocalized,
  kPoseJumped,
  kTooFast,
  kStickMoved,
  kStickIncomplete,
  kStickNotFinite,
  kStickBeyondRange,
  kUserSilent,
  kLeaderSilent,
  kNoGoal,
  kNotFitted,
  kPeopleSilent,
  kObstaclesSilent,
  kPlanTimeout,
  kPlanInfeasible,
  kPlanRefused,
  kNothingAdmissible,
  kEmergencyStop,
  kLetGoFirst,
  kSteerFirst,
  kSharedSilent,
  kNoCommand,
  kClockSilent,
  kFilterSilent,
  kCommandNotFinite,
  kTwistInDoubt,
  kUnseenGround,
  kStopped,
  kOthersDrive,
  kNotEnforcing,
  kCount
};

/// Whether something is wrong, so that the table has a remedy.
[[nodiscard]] constexpr bool is_trouble(Reason reason) { return reason >= Reason::kNothingSensed; }

/// The text of a reason as nodes publish it. "…" stands for a variable part. A reason without it
/// may be followed by ": " or " (" and details. `remedy` is empty unless is_trouble().
struct ReasonText {
  const char* text;    ///< what is the matter, for a person
  const char* remedy;  ///< what to do about it; empty if nothing is wrong
};

// The only table of texts. A new reason does not compile without its text and remedy: the switch
// has no default, and the assertion below requires both.
/// Text and remedy of a reason.
[[nodiscard]] constexpr ReasonText words(Reason reason) {
  switch (reason) {
    case Reason::kNone:
    case Reason::kOther:
      break;
    case Reason::kClear:
      return {"clear", ""};
    case Reason::kSlowed:
      return {"slowed", ""};
    case Reason::kDeflected:
      return {"deflected", ""};
    case Reason::kBackingOut:
      return {"backing out", ""};
    case Reason::kFollowsSource:
      return {"in charge", ""};
    case Reason::kHandover:
      return {"handover", ""};
    case Reason::kUserTakesOver:
      return {"the person takes over", ""};
    case Reason::kPlanOptimal:
      return {"optimal", ""};
    case Reason::kPlanAcceptable:
      return {"acceptable", ""};
    case Reason::kArcChosen:
      return {"chosen", ""};
    case Reason::kNothingSensed:
      return {"no data on scan or cloud_in…",
              "start a sensor's driver, or remap scan or cloud_in to its topic"};
    case Reason::kSensorMissing:
      return {"… is silent, and required_sensors names it…",
              "start the sensor's driver, or take the sensor out of required_sensors"};
    case Reason::kSensorSilent:
      return {"… is silent: is its driver running?…",
              "start the sensor's driver again; if the sensor was taken off, restart "
              "octomap_builder"};
    case Reason::kSensorBlind:
      return {"… gives no valid range…",
              "uncover or clean the sensor; name in no_return what it sends where nothing is in "
              "range"};
    case Reason::kSensorFrozen:
      return {"… is frozen…",
              "restart the sensor's driver; if the wheels slip, free the robot and call "
              "octomap_builder's ~/reset"};
    case Reason::kSensorRefused:
      return {"… is refused: …", "mend the field of the sensor's message that the reason names"};
    case Reason::kSensorUnplaced:
      return {"… is dropped: /tf_static does not say where…",
              "publish where the sensor sits on /tf_static, or set scan_pose or cloud_pose"};
    case Reason::kSensorInWorld:
      return {"… is dropped: it is given in frame…", "publish the sensor in its own frame"};
    case Reason::kSensorUnlocalized:
      return {"… is dropped: not localized…", "publish odom, and map → odom on /tf"};
    case Reason::kSensorUntimely:
      return {"… is dropped: no odometry of its time…",
              "set the clock of the computer that stamps it, or restart its driver"};
    case Reason::kSensorTooFar:
      return {"… is farther than an OctoMap reaches",
              "let the localiser place the robot nearer to the map's origin"};
    case Reason::kFewBeams:
      return {"… of its beams are usable…", "clean the sensor, or uncover it"};
    case Reason::kSensingSilent:
      return {"sensing_status is silent…", "start octomap_builder again"};
    case Reason::kLocalMapSilent:
      return {"octomap_local is silent", "start octomap_builder, or set map_source: static"};
    case Reason::kNoMap:
    case Reason::kNoMapYet:
      return {reason == Reason::kNoMap ? "no map" : "no map yet",
              "start map_server with a map, or octomap_builder with map_source: local"};
    case Reason::kOtherFrame:
      return {"… is given in frame …",
              "publish on /tf where that frame is, or let its sender use the frame of map_frame or "
              "odom_frame"};
    case Reason::kMapNotPlaced:
      return {"… cannot be placed: …", "publish on /tf where the map's frame is"};
    case Reason::kMapMoved:
      return {"… is being placed anew: …",
              "wait; if it lasts, let only one localiser publish the map's frame"};
    case Reason::kNotLocalized:
      return {"not localized",
              "publish odom of base_frame, and map → odom on /tf; name the frames with map_frame, "
              "odom_frame and base_frame, or set map_is_odom: true without a localiser"};
    case Reason::kPoseJumped:
      return {"pose jumped", "wait; if two nodes publish odom or map → odom, stop one"};
    case Reason::kTooFast:
      return {"odom is faster than the robot can be (v_max, v_min, w_max)",
              "let the base give odom in m and s, or correct v_max, v_min and w_max"};
    case Reason::kStickMoved:
      return {"stick is not at rest",
              "let go of the stick; if it rests beside its centre, raise deadzone"};
    case Reason::kStickIncomplete:
      return {"joy has no …",
              "set axis_linear, axis_angular and deadman_button to what the device has"};
    case Reason::kStickNotFinite:
      return {"… is not finite", "let the device's driver send numbers"};
    case Reason::kStickBeyondRange:
      return {"… is beyond axis_range", "set axis_range to what the device sends at full stick"};
    case Reason::kUserSilent:
      return {"cmd_vel_user is silent",
              "hold the dead-man button and steer, or publish cmd_vel_user at 20 Hz"};
    case Reason::kLeaderSilent:
      return {"leader_pose is silent", "start teleop and steer, or set method: intention"};
    case Reason::kNoGoal:
      return {"no goal_pose yet", "publish goal_pose, or set the planner's parameter goal"};
    case Reason::kNotFitted:
      return {"not fitted yet", "wait: shapes are being fitted to the map"};
    case Reason::kPeopleSilent:
      return {"people are silent", "start what publishes people, or set people: false"};
    case Reason::kObstaclesSilent:
      return {"obstacles are silent", "start obstacle_extractor"};
    case Reason::kPlanTimeout:
      return {"timeout",
              "wait; if it lasts, raise time_budget, or let nothing else load the "
              "computer"};
    case Reason::kPlanInfeasible:
      return {"infeasible", "steer to where there is room"};
    case Reason::kPlanRefused:
      return {"refused", "see the planner's log: its inputs are not finite"};
    case Reason::kNothingAdmissible:
      return {"nothing is admissible: braking", "steer to where there is room"};
    case Reason::kEmergencyStop:
      return {"emergency stop",
              "let every sender of e_stop publish false, then call release_emergency_stop"};
    case Reason::kLetGoFirst:
      return {"let go of the stick first", "let go of the stick for a second"};
    case Reason::kSteerFirst:
      return {"steer to drive on", "steer"};
    case Reason::kSharedSilent:
      return {"cmd_vel_shared is silent", "start a planner, or set policy manual"};
    case Reason::kNoCommand:
      return {"no command",
              "start arbitration, and steer, publish cmd_vel_nav or give the planner a goal"};
    case Reason::kClockSilent:
      return {"/clock is silent", "start what publishes /clock, or set use_sim_time: false"};
    case Reason::kFilterSilent:
      return {"safety filter is silent", "start safety_filter again"};
    case Reason::kCommandNotFinite:
      return {"command not finite", "mend the node that publishes cmd_vel_arbitrated"};
    case Reason::kTwistInDoubt:
      return {"stopped: odom's twist contradicts its poses",
              "let odom give its twist in child_frame_id, forward positive"};
    case Reason::kUnseenGround:
      return {"unseen ground", "turn a sensor there, or raise unseen_speed"};
    case Reason::kStopped:
      return {"stopped", "steer to where there is room"};
    case Reason::kOthersDrive:
      return {"others publish cmd_vel, past this filter",
              "remap them to cmd_vel_nav or cmd_vel_user"};
    case Reason::kNotEnforcing:
      return {"NOT ENFORCING: commands pass unchanged", "set enforce: true"};
    case Reason::kCount:
      break;
  }
  return {"", ""};
}

/// The texts, by the reasons' numbers.
inline constexpr auto kReasons = [] {
  std::array<ReasonText, static_cast<std::size_t>(Reason::kCount)> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = words(static_cast<Reason>(i));
  return all;
}();

static_assert(
    [] {
      for (std::size_t i = static_cast<std::size_t>(Reason::kClear); i < kReasons.size(); ++i)
        if (std::string_view{kReasons[i].text}.empty() ||
            std::string_view{kReasons[i].remedy}.empty() == is_trouble(static_cast<Reason>(i)))
          return false;
      return true;
    }(),
    "every reason has words, and those of trouble have a remedy");

/// The text of words().
[[nodiscard]] constexpr const char* text_of(Reason reason) { return words(reason).text; }

/// The reason of a text as a node published it, with or without a "node: " prefix: kNone if the
/// text is empty, kOther if the table does not have it. If several reasons match, the longest one.
[[nodiscard]] Reason reason_in(std::string_view written);

/// The remedy for the reason in a published text; empty if the table has none.
[[nodiscard]] inline std::string remedy_for(std::string_view written) {
  return words(reason_in(written)).remedy;
}

}  // namespace tandem
