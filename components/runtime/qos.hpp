// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Whether lost messages are sent again.
enum class Reliability { kBestEffort, kReliable };
/// Whether late subscriptions get earlier messages.
enum class Durability { kVolatile, kTransientLocal };

/// QoS of a publisher or subscription. The default is ROS 2's default profile.
struct QoS {
  Reliability reliability = Reliability::kReliable;  ///< of delivery
  Durability durability = Durability::kVolatile;     ///< for late subscriptions
  int depth = 10;                                    ///< samples kept (keep last)
  double lifespan =
      std::numeric_limits<double>::infinity();  ///< [s] older samples are not delivered

  bool operator==(const QoS&) const = default;
};

/// ROS 2's default profile: reliable, volatile, keep last 10.
inline constexpr QoS kDefault{};
/// ROS 2's profile for sensors: best effort, the last five.
inline constexpr QoS kSensorData{Reliability::kBestEffort, Durability::kVolatile, 5};
/// For what late subscriptions must get: reliable, the last message is kept.
inline constexpr QoS kLatched{Reliability::kReliable, Durability::kTransientLocal, 1};
/// Of service requests and responses, as ROS 2.
inline constexpr QoS kServices{};
/// The lifespan keeps a process that resumes from a stall from replaying stale clock samples.
inline constexpr QoS kClock{.reliability = Reliability::kBestEffort, .depth = 1, .lifespan = 0.2};

/// Best effort, volatile, keep last `depth`.
constexpr QoS kBestEffort(int depth) {
  return {Reliability::kBestEffort, Durability::kVolatile, depth};
}

/// The QoS in one line, as "reliable, transient local, depth 1".
[[nodiscard]] TANDEM_EXPORT std::string to_text(const QoS& qos);

/// The policies by which DDS decides whether two endpoints are compatible. Kinds are in DDS's
/// order: a higher value is a stronger guarantee.
struct Policies {
  int reliability = 0;  ///< 0 best effort, 1 reliable
  int durability = 0;   ///< 0 volatile, 1 transient local, 2 transient, 3 persistent
  double deadline = std::numeric_limits<double>::infinity();  ///< [s]
  int liveliness = 0;  ///< 0 automatic, 1 manual by participant, 2 manual by topic

  bool operator==(const Policies&) const = default;
};

/// The policies that an endpoint with this QoS announces.
[[nodiscard]] TANDEM_EXPORT Policies policies_of(const QoS& qos);

/// A policy whose offered value is weaker than the requested one, as text.
struct QosMismatch {
  std::string policy, offered, requested;  ///< "reliability", "best_effort", "reliable"
};

/// The parameter below qos_overrides and the topic's name that resolves the mismatch, for example
/// "reliability: best_effort", set either at the subscription (`at_subscription`) or at the
/// publisher. Empty if no parameter does.
[[nodiscard]] TANDEM_EXPORT std::string override_for(const QosMismatch& mismatch,
                                                     bool at_subscription);

/// QoS of a subscription with that depth that is compatible with all of these publishers.
[[nodiscard]] TANDEM_EXPORT QoS request_for(const std::vector<Policies>& offered, int depth);

/// The policies in which the offer does not satisfy the request; empty if compatible.
[[nodiscard]] TANDEM_EXPORT std::vector<QosMismatch> qos_mismatches(const Policies& offered,
                                                                    const Policies& requested);

}  // namespace tandem::runtime

namespace tandem {
namespace rt = runtime;
}
