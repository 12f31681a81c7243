// SPDX-License-Identifier: Apache-2.0
// In: /diagnostics. Out: what nodes say is wrong with themselves.
#pragma once

#include <map>
#include <msgs.hpp>
#include <string>
#include <vector>

#include "bringup/doctor.hpp"

namespace tandem {

/// The last word of each part of each node on /diagnostics, by the part's name.
using Diagnoses = std::map<std::string, diagnostic_msgs::msg::DiagnosticStatus>;

/// Adds what a message says. Of more than a thousand parts, further ones are not kept.
void add(Diagnoses& diagnoses, const diagnostic_msgs::msg::DiagnosticArray& msg);

/// All that is not OK, errors first. A node that repeats another's word ("safety filter: no map
/// yet" beside "no map yet") is left out: the first cause is what can be mended. The value `remedy`
/// of a status, if it has one, says how.
[[nodiscard]] std::vector<Finding> examine(const Diagnoses& diagnoses);

}  // namespace tandem
