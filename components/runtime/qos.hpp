// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace tandem::runtime {

enum class Reliability { kBestEffort, kReliable };
enum class Durability { kVolatile, kTransientLocal };

/// What sender and receiver of a topic agree on. The default is ROS 2's default profile.
struct QoS {
  Reliability reliability = Reliability::kReliable;
  Durability durability = Durability::kVolatile;
  int depth = 10;  ///< samples kept (keep last)
  double lifespan =
      std::numeric_limits<double>::infinity();  ///< [s] older samples are not delivered

  bool operator==(const QoS&) const = default;
};

inline constexpr QoS kDefault{};
inline constexpr QoS kSensorData{Reliability::kBestEffort, Durability::kVolatile, 5};
inline constexpr QoS kLatched{Reliability::kReliable, Durability::kTransientLocal, 1};
inline constexpr QoS kServices{};
/// The lifespan is for a process that stood still: it must not live through the time it missed, in
/// which what it last heard is still news.
inline constexpr QoS kClock{.reliability = Reliability::kBestEffort, .depth = 1, .lifespan = 0.2};

/// Best effort, volatile, keep last `depth`.
constexpr QoS kBestEffort(int depth) {
  return {Reliability::kBestEffort, Durability::kVolatile, depth};
}

/// The policies by which DDS decides whether two endpoints fit. Kinds in DDS's order: a higher one
/// promises more.
struct Policies {
  int reliability = 0;  ///< 0 best effort, 1 reliable
  int durability = 0;   ///< 0 volatile, 1 transient local, 2 transient, 3 persistent
  double deadline = std::numeric_limits<double>::infinity();  ///< [s]
  int liveliness = 0;  ///< 0 automatic, 1 manual by participant, 2 manual by topic
};

[[nodiscard]] Policies policies_of(const QoS& qos);

/// A policy of which less is offered than is requested, in words.
struct Misfit {
  std::string policy, offered, requested;
};

/// What to set the policy to at the end that requests too much (`at_subscription`), or at the one
/// that offers too little: "reliability: best_effort", a parameter below `qos_overrides.<topic>.`
/// Empty: no parameter mends it.
[[nodiscard]] std::string override_for(const Misfit& misfit, bool at_subscription);

/// A subscription of that depth that hears every one of these publishers.
[[nodiscard]] QoS request_for(const std::vector<Policies>& offered, int depth);

/// Every policy by which an offering writer fails a requesting reader; empty: they fit.
[[nodiscard]] std::vector<Misfit> misfits(const Policies& offered, const Policies& requested);

}  // namespace tandem::runtime

namespace tandem {
namespace rt = runtime;
}
