// SPDX-License-Identifier: Apache-2.0
// In: results of drives. Out: what a person reads: a progress line and a table.
#pragma once

#include <string>
#include <vector>

#include "bringup/drive/drive_log.hpp"

namespace tandem {

/// One line for a moment of a drive.
[[nodiscard]] std::string progress_line(const Progress& progress);

/// A row per drive, and below it whatever should have held and did not.
[[nodiscard]] std::string summary_table(const std::vector<DriveResult>& results);

}  // namespace tandem
