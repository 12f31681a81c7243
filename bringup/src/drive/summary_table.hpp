// SPDX-License-Identifier: Apache-2.0
// Formats the progress and the results of drives for a terminal.
#pragma once

#include <string>
#include <vector>

#include "bringup/drive/drive_log.hpp"

namespace tandem {

/// One line on the current state of a drive.
[[nodiscard]] std::string progress_line(const Progress& progress);

/// A row per drive, followed by the expectations that failed.
[[nodiscard]] std::string summary_table(const std::vector<DriveResult>& results);

}  // namespace tandem
