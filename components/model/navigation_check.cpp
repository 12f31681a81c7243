// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/navigation_check.hpp"

namespace tandem {
namespace {

constexpr std::string_view kPolicy = "autonomous";

std::string other(const char* what, const std::string& is, std::string_view needed) {
  return std::string{"the "} + what + " is " + is + ", not " + std::string{needed};
}

}  // namespace

std::optional<NavigationHindrance> hindrance_to(std::string_view method,
                                                const NavigationState& state) {
  if (state.emergency_stop) return NavigationHindrance::kEmergencyStop;
  if (state.policy.empty()) return NavigationHindrance::kArbitrationSilent;
  if (state.policy != kPolicy) return NavigationHindrance::kOtherPolicy;
  if (state.method.empty()) return NavigationHindrance::kPlannerSilent;
  if (state.method != method) return NavigationHindrance::kOtherMethod;
  if (!state.filter_enforces) return NavigationHindrance::kFilterSilent;
  if (!*state.filter_enforces) return NavigationHindrance::kFilterNotEnforcing;
  if (!state.not_localized.empty()) return NavigationHindrance::kNotLocalized;
  return std::nullopt;
}

std::string in_words(NavigationHindrance hindrance, std::string_view method,
                     const NavigationState& state) {
  switch (hindrance) {
    case NavigationHindrance::kEmergencyStop:
      return "emergency stop";
    case NavigationHindrance::kArbitrationSilent:
      return "arbitration is silent";
    case NavigationHindrance::kOtherPolicy:
      return other("policy", state.policy, kPolicy);
    case NavigationHindrance::kPlannerSilent:
      return "the planner is silent";
    case NavigationHindrance::kOtherMethod:
      return other("planner's method", state.method, method);
    case NavigationHindrance::kFilterSilent:
      return "the safety filter is silent";
    case NavigationHindrance::kFilterNotEnforcing:
      return "the safety filter does not enforce";
    case NavigationHindrance::kNotLocalized:
      return state.not_localized;
  }
  return {};
}

}  // namespace tandem
