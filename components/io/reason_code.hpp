// SPDX-License-Identifier: Apache-2.0
// Converts between the reasons of the table and the numbers that status messages carry.
#pragma once

#include <msgs.hpp>

#include "tandem/model/reasons.hpp"

namespace tandem {

/// The message with the number of a reason.
[[nodiscard]] tandem_msgs::msg::ReasonCode to_msg(Reason reason);

/// kOther for a number that this version does not know.
[[nodiscard]] Reason from_msg(const tandem_msgs::msg::ReasonCode& msg);

}  // namespace tandem
