// SPDX-License-Identifier: Apache-2.0
// The range of OctoMap's voxel keys.
#pragma once

namespace tandem {

inline constexpr int kTreeDepth = 16;                     // bits of a key
inline constexpr int kMiddleKey = 1 << (kTreeDepth - 1);  // key of the voxel that starts at 0
inline constexpr int kLastKey = (1 << kTreeDepth) - 1;

}  // namespace tandem
