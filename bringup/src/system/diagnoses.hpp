// SPDX-License-Identifier: Apache-2.0
// Collects the problems that nodes report on /diagnostics.
#pragma once

#include <string>
#include <vector>

#include "bringup/system/doctor.hpp"
#include "tandem/io/diagnostics.hpp"

namespace tandem {

/// All statuses that are not OK, errors first. Statuses that repeat another one ("safety filter: no
/// map yet" next to "no map yet") or only wait for the output of a failing node are left out: only
/// the first cause can be fixed. Statuses already in `found` are left out too. A finding's remedy
/// is the status's value `remedy`, if it has one. That nobody steers is a note.
[[nodiscard]] std::vector<Finding> examine(const Diagnoses& diagnoses,
                                           const std::vector<Finding>& found = {});

}  // namespace tandem
