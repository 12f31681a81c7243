// SPDX-License-Identifier: Apache-2.0
// Keeps a time and a mark for each voxel of an OctoMap.
#pragma once

#include <octomap/OcTreeKey.h>

#include <array>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

namespace tandem {

/// The time [s] at which each voxel was last covered, and a mark. Stored in flat blocks: a scan
/// sets tens of thousands of times, and a hash table entry for each would cost as much as the map.
class VoxelTimes {
  static constexpr int kSide = 16;  // voxels per block along x and y; 1 along z
  static constexpr std::size_t kVoxels = std::size_t{kSide} * kSide;
  static constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
  struct Block {
    Block() { times.fill(kNever); }
    std::array<double, kVoxels> times;
    std::bitset<kVoxels> marks;
  };

 public:
  /// What is kept of a voxel.
  struct Voxel {
    double& t;  ///< [s]
    std::bitset<kVoxels>::reference
        is_settled;  ///< whether another beam through it changes nothing
  };

  /// A voxel, to read and to set: at first its time is NaN and its mark false.
  Voxel at(const octomap::OcTreeKey& key) {
    Block& block = blocks_[block_of(key)];
    const std::size_t place = place_of(key);
    return {block.times[place], block.marks[place]};
  }

  /// Calls `visit(key, t)` for each voxel with a time and removes the times and marks for which it
  /// returns true.
  template <class Visit>
  void forget_if(const Visit& visit) {
    for (auto& [id, block] : blocks_)
      for (std::size_t place = 0; place < kVoxels; ++place) {
        double& t = block.times[place];
        if (std::isnan(t) || !visit(key_of(id, place), t)) continue;
        t = kNever;
        block.marks[place] = false;
      }
  }

  /// Removes the times and marks of all voxels outside the keys [low, high] along x and y.
  void keep_between(const octomap::OcTreeKey& low, const octomap::OcTreeKey& high) {
    const auto is_inside = [&](const octomap::OcTreeKey& key) {
      return key[0] >= low[0] && key[0] <= high[0] && key[1] >= low[1] && key[1] <= high[1];
    };
    std::erase_if(blocks_, [&](const auto& entry) {
      const octomap::OcTreeKey first = key_of(entry.first, 0);
      return first[0] + kSide <= low[0] || first[0] > high[0] || first[1] + kSide <= low[1] ||
             first[1] > high[1];
    });
    forget_if([&](const octomap::OcTreeKey& key, double) { return !is_inside(key); });
  }
  /// Forgets all times.
  void clear() { blocks_.clear(); }

 private:
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
