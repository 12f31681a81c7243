// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/reason_code.hpp"

#include <cstddef>
#include <cstdint>

namespace tandem {
namespace {

namespace code = tandem_msgs::msg::ReasonCode_Constants;

struct Row {
  Reason reason;
  std::uint8_t value;
};

// Every reason, beside the message's constant.
constexpr Row kRows[]{
    {Reason::kNone, code::NONE},
    {Reason::kOther, code::OTHER},
    {Reason::kClear, code::CLEAR},
    {Reason::kSlowed, code::SLOWED},
    {Reason::kDeflected, code::DEFLECTED},
    {Reason::kBackingOut, code::BACKING_OUT},
    {Reason::kFollowsSource, code::FOLLOWS_SOURCE},
    {Reason::kHandover, code::HANDOVER},
    {Reason::kUserTakesOver, code::USER_TAKES_OVER},
    {Reason::kPlanOptimal, code::PLAN_OPTIMAL},
    {Reason::kPlanAcceptable, code::PLAN_ACCEPTABLE},
    {Reason::kArcChosen, code::ARC_CHOSEN},
    {Reason::kNothingSensed, code::NOTHING_SENSED},
    {Reason::kSensorMissing, code::SENSOR_MISSING},
    {Reason::kSensorSilent, code::SENSOR_SILENT},
    {Reason::kSensorBlind, code::SENSOR_BLIND},
    {Reason::kSensorFrozen, code::SENSOR_FROZEN},
    {Reason::kSensorRefused, code::SENSOR_REFUSED},
    {Reason::kSensorUnplaced, code::SENSOR_UNPLACED},
    {Reason::kSensorInWorld, code::SENSOR_IN_WORLD},
    {Reason::kSensorUnlocalized, code::SENSOR_UNLOCALIZED},
    {Reason::kSensorUntimely, code::SENSOR_UNTIMELY},
    {Reason::kSensorTooFar, code::SENSOR_TOO_FAR},
    {Reason::kFewBeams, code::FEW_BEAMS},
    {Reason::kSensingSilent, code::SENSING_SILENT},
    {Reason::kLocalMapSilent, code::LOCAL_MAP_SILENT},
    {Reason::kNoMap, code::NO_MAP},
    {Reason::kNoMapYet, code::NO_MAP_YET},
    {Reason::kOtherFrame, code::OTHER_FRAME},
    {Reason::kMapNotPlaced, code::MAP_NOT_PLACED},
    {Reason::kMapMoved, code::MAP_MOVED},
    {Reason::kNotLocalized, code::NOT_LOCALIZED},
    {Reason::kPoseJumped, code::POSE_JUMPED},
    {Reason::kTooFast, code::TOO_FAST},
    {Reason::kStickMoved, code::STICK_MOVED},
    {Reason::kStickIncomplete, code::STICK_INCOMPLETE},
    {Reason::kStickNotFinite, code::STICK_NOT_FINITE},
    {Reason::kStickBeyondRange, code::STICK_BEYOND_RANGE},
    {Reason::kUserSilent, code::USER_SILENT},
    {Reason::kLeaderSilent, code::LEADER_SILENT},
    {Reason::kNoGoal, code::NO_GOAL},
    {Reason::kNotFitted, code::NOT_FITTED},
    {Reason::kPeopleSilent, code::PEOPLE_SILENT},
    {Reason::kObstaclesSilent, code::OBSTACLES_SILENT},
    {Reason::kPlanTimeout, code::PLAN_TIMEOUT},
    {Reason::kPlanInfeasible, code::PLAN_INFEASIBLE},
    {Reason::kPlanRefused, code::PLAN_REFUSED},
    {Reason::kNothingAdmissible, code::NOTHING_ADMISSIBLE},
    {Reason::kEmergencyStop, code::EMERGENCY_STOP},
    {Reason::kLetGoFirst, code::LET_GO_FIRST},
    {Reason::kSteerFirst, code::STEER_FIRST},
    {Reason::kSharedSilent, code::SHARED_SILENT},
    {Reason::kNoCommand, code::NO_COMMAND},
    {Reason::kClockSilent, code::CLOCK_SILENT},
    {Reason::kFilterSilent, code::FILTER_SILENT},
    {Reason::kCommandNotFinite, code::COMMAND_NOT_FINITE},
    {Reason::kTwistInDoubt, code::TWIST_IN_DOUBT},
    {Reason::kUnseenGround, code::UNSEEN_GROUND},
    {Reason::kStopped, code::STOPPED},
    {Reason::kOthersDrive, code::OTHERS_DRIVE},
    {Reason::kNotEnforcing, code::NOT_ENFORCING},
};

constexpr bool is_complete() {
  std::size_t count = 0;
  for (const Row& row : kRows)
    if (row.reason != static_cast<Reason>(count++) ||
        row.value != static_cast<std::uint8_t>(row.reason))
      return false;
  return count == kReasons.size();
}
static_assert(is_complete(), "the constants of tandem_msgs/ReasonCode are the numbers of Reason");

}  // namespace

tandem_msgs::msg::ReasonCode to_msg(Reason reason) {
  tandem_msgs::msg::ReasonCode msg;
  msg.value(static_cast<std::uint8_t>(reason));
  return msg;
}

Reason from_msg(const tandem_msgs::msg::ReasonCode& msg) {
  return msg.value() < kReasons.size() ? static_cast<Reason>(msg.value()) : Reason::kOther;
}

}  // namespace tandem
