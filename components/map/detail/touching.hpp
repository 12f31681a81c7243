// SPDX-License-Identifier: Apache-2.0
// How far two cells must overlap to count as overlapping.
#pragma once

namespace tandem {

inline constexpr double kTouching = 1e-6;  // of a cell; a common edge is not an overlap

}  // namespace tandem
