// SPDX-License-Identifier: Apache-2.0
// Keeps a time for each voxel of an OctoMap.
#pragma once

#include <octomap/OcTreeKey.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

namespace tandem {

/// The time [s] at which each voxel was last covered. Stored in flat blocks: a scan sets tens of
/// thousands of times, and a hash table entry for each would cost as much as the map.
class VoxelTimes {
 public:
  /// Sets a voxel's time [s].
  void set(const octomap::OcTreeKey& key, double t) {
    blocks_.try_emplace(block_of(key), empty()).first->second[place_of(key)] = t;
  }

  /// Calls `visit(key, t)` for each voxel with a time and removes the times for which it returns
  /// true.
  template <class Visit>
  void forget_if(const Visit& visit) {
    for (auto& [id, block] : blocks_)
      for (std::size_t place = 0; place < block.size(); ++place)
        if (!std::isnan(block[place]) && visit(key_of(id, place), block[place]))
          block[place] = kNever;
  }

  /// Removes the times of all voxels outside the keys [low, high], except for some near the border.
  void keep_between(const octomap::OcTreeKey& low, const octomap::OcTreeKey& high) {
    std::erase_if(blocks_, [&](const auto& entry) {
      const octomap::OcTreeKey first = key_of(entry.first, 0);
      return first[0] + kSide <= low[0] || first[0] > high[0] || first[1] + kSide <= low[1] ||
             first[1] > high[1];
    });
  }
  /// Forgets all times.
  void clear() { blocks_.clear(); }

 private:
  static constexpr int kSide = 16;  // voxels per block along x and y; 1 along z
  static constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
  using Block = std::array<double, std::size_t{kSide} * kSide>;

  static Block empty() {
    Block block;
    block.fill(kNever);
    return block;
  }
  static std::uint64_t block_of(const octomap::OcTreeKey& key) {
    return std::uint64_t{key[2]} << 32U | std::uint64_t{key[1]} / kSide << 16U | key[0] / kSide;
  }
  static std::size_t place_of(const octomap::OcTreeKey& key) {
    return std::size_t{key[1]} % kSide * kSide + key[0] % kSide;
  }
  static octomap::OcTreeKey key_of(std::uint64_t block, std::size_t place) {
    const auto low = [&](unsigned shift) {
      return static_cast<std::size_t>(block >> shift & 0xFFFFU);
    };
    return {static_cast<octomap::key_type>(low(0) * kSide + place % kSide),
            static_cast<octomap::key_type>(low(16) * kSide + place / kSide),
            static_cast<octomap::key_type>(low(32))};
  }

  std::unordered_map<std::uint64_t, Block> blocks_;
};

}  // namespace tandem
