// SPDX-License-Identifier: Apache-2.0
// Draws the report of a study from the results in its folder.
#pragma once

#include <string>

namespace tandem {

/// Runs report.py on a study's folder. Without matplotlib, prints how to install it and returns.
/// Throws std::runtime_error if the script fails.
void draw_report(const std::string& folder);

}  // namespace tandem
