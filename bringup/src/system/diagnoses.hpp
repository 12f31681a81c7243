// SPDX-License-Identifier: Apache-2.0
// In: /diagnostics. Out: what nodes say is wrong with themselves.
#pragma once

#include <string>
#include <vector>

#include "bringup/system/doctor.hpp"
#include "tandem/io/diagnostics.hpp"

namespace tandem {

/// All that is not OK, errors first. A node that repeats another's word ("safety filter: no map
/// yet" beside "no map yet"), or waits for what an unwell node gives, is left out: the first cause
/// is what can be mended. So is what `found` has already. The value `remedy` of a status, if it has
/// one, says how.
[[nodiscard]] std::vector<Finding> examine(const Diagnoses& diagnoses,
                                           const std::vector<Finding>& found = {});

}  // namespace tandem
