// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/reasons.hpp"
#include "tandem/safety_filter/safety_filter.hpp"

namespace tandem {

const char* name(FilterReason reason) {
  switch (reason) {
    case FilterReason::kClear:
      return text_of(Reason::kClear);
    case FilterReason::kSlowed:
      return text_of(Reason::kSlowed);
    case FilterReason::kDeflected:
      return text_of(Reason::kDeflected);
    case FilterReason::kBackingOut:
      return text_of(Reason::kBackingOut);
    case FilterReason::kUnseen:
      return text_of(Reason::kUnseenGround);
    case FilterReason::kStopped:
      return text_of(Reason::kStopped);
    case FilterReason::kStoppedInDoubt:
      return text_of(Reason::kTwistInDoubt);
    case FilterReason::kNoCommand:
      return text_of(Reason::kNoCommand);
    case FilterReason::kNotFinite:
      return text_of(Reason::kCommandNotFinite);
    case FilterReason::kNotLocalized:
      return text_of(Reason::kNotLocalized);
    case FilterReason::kPoseJumped:
      return text_of(Reason::kPoseJumped);
    case FilterReason::kTooFast:
      return text_of(Reason::kTooFast);
    case FilterReason::kNoMap:
      return text_of(Reason::kNoMap);
    case FilterReason::kNoPeople:
      return text_of(Reason::kPeopleSilent);
    case FilterReason::kClockSilent:
      return text_of(Reason::kClockSilent);
  }
  return "unknown";
}

}  // namespace tandem
