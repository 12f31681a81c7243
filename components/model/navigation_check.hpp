// SPDX-License-Identifier: Apache-2.0
// In: what the nodes report. Out: whether the planner may drive to a goal of a program, or why not.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tandem {

/// What the nodes report that a drive to a goal needs.
struct NavigationState {
  std::string policy;                   ///< arbitration's policy; empty: arbitration is silent
  bool emergency_stop = false;          ///< pressed or not released
  std::string method;                   ///< the planner's method; empty: the planner is silent
  std::optional<bool> filter_enforces;  ///< nullopt: the safety filter is silent
  std::string not_localized;            ///< why the pose is unknown; empty: it is known
};

/// What prevents a drive to a goal.
enum class NavigationHindrance {
  kEmergencyStop,
  kArbitrationSilent,
  kOtherPolicy,  ///< the policy is not `autonomous`
  kPlannerSilent,
  kOtherMethod,  ///< the planner's method is not the one that the goal needs
  kFilterSilent,
  kFilterNotEnforcing,
  kNotLocalized,
};

/// What prevents a drive by that method of the planner ("goal"); nullopt: nothing.
[[nodiscard]] std::optional<NavigationHindrance> hindrance_to(std::string_view method,
                                                              const NavigationState& state);

/// The hindrance in words: "the policy is shared, not autonomous".
[[nodiscard]] std::string in_words(NavigationHindrance hindrance, std::string_view method,
                                   const NavigationState& state);

}  // namespace tandem
