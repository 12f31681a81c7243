// SPDX-License-Identifier: Apache-2.0
#include "safety_filter/safety_filter.hpp"

namespace tandem {

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
    case FilterReason::kUnseen:
      return "unseen ground";
    case FilterReason::kStopped:
      return "stopped";
    case FilterReason::kStoppedInDoubt:
      return "stopped: odom's twist contradicts its poses";
    case FilterReason::kNoCommand:
      return "no command";
    case FilterReason::kNotFinite:
      return "command not finite";
    case FilterReason::kNotLocalized:
      return "not localized";
    case FilterReason::kPoseJumped:
      return "pose jumped";
    case FilterReason::kTooFast:
      return "odom is faster than the robot can be (v_max, v_min, w_max)";
    case FilterReason::kNoMap:
      return "no map";
    case FilterReason::kNoPeople:
      return "people silent";
    case FilterReason::kClockSilent:
      return "/clock is silent";
  }
  return "unknown";
}

}  // namespace tandem
