// SPDX-License-Identifier: Apache-2.0
// In: the results of a study, in a folder. Out: its report, drawn by report.py.
#pragma once

#include <string>

namespace tandem {

/// Runs report.py on a study's folder. Without matplotlib it prints how to install it. Throws
/// std::runtime_error if the script fails.
void draw_report(const std::string& folder);

}  // namespace tandem
