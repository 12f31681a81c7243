// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tandem::runtime {

enum class Reliability { kBestEffort, kReliable };
enum class Durability { kVolatile, kTransientLocal };

/// What sender and receiver of a topic agree on. The default is ROS 2's default profile.
struct QoS {
  Reliability reliability = Reliability::kReliable;
  Durability durability = Durability::kVolatile;
  int depth = 10;  ///< samples kept (keep last)

  bool operator==(const QoS&) const = default;
};

inline constexpr QoS kDefault{};
inline constexpr QoS kSensorData{Reliability::kBestEffort, Durability::kVolatile, 5};
inline constexpr QoS kLatched{Reliability::kReliable, Durability::kTransientLocal, 1};
inline constexpr QoS kServices{};
inline constexpr QoS kClock{Reliability::kBestEffort, Durability::kVolatile, 1};

/// Best effort, volatile, keep last `depth`.
constexpr QoS kBestEffort(int depth) {
  return {Reliability::kBestEffort, Durability::kVolatile, depth};
}

}  // namespace tandem::runtime
