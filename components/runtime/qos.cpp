// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/qos.hpp"

#include <algorithm>
#include <array>

#include <spdlog/fmt/fmt.h>

namespace tandem::runtime {
namespace {

constexpr std::array<const char*, 2> kReliabilities{"best effort", "reliable"};
constexpr std::array<const char*, 4> kDurabilities{"volatile", "transient local", "transient",
                                                   "persistent"};
constexpr std::array<const char*, 3> kLivelinesses{"automatic", "manual by participant",
                                                   "manual by topic"};

template <std::size_t n>
void compare(const char* policy, const std::array<const char*, n>& names, int offered,
             int requested, std::vector<QosMismatch>& found) {
  const auto name = [&](int kind) {
    return names[static_cast<std::size_t>(std::clamp(kind, 0, static_cast<int>(n) - 1))];
  };
  if (offered < requested) found.push_back({policy, name(offered), name(requested)});
}

std::string in_seconds(double duration) {
  return duration < std::numeric_limits<double>::infinity() ? fmt::format("{} s", duration)
                                                            : "none";
}

}  // namespace

std::string to_text(const QoS& qos) {
  const Policies policies = policies_of(qos);
  std::string text = fmt::format(
      "{}, {}, depth {}", kReliabilities[static_cast<std::size_t>(policies.reliability)],
      kDurabilities[static_cast<std::size_t>(policies.durability)], qos.depth);
  if (qos.lifespan < std::numeric_limits<double>::infinity())
    text += fmt::format(", lifespan {} s", qos.lifespan);
  return text;
}

Policies policies_of(const QoS& qos) {
  return {.reliability = qos.reliability == Reliability::kReliable ? 1 : 0,
          .durability = qos.durability == Durability::kTransientLocal ? 1 : 0};
}

QoS request_for(const std::vector<Policies>& offered, int depth) {
  const auto all = [&](auto promises) {
    return std::all_of(offered.begin(), offered.end(), promises);
  };
  QoS qos{.depth = depth};
  if (!all([](const auto& o) { return o.reliability >= 1; }))
    qos.reliability = Reliability::kBestEffort;
  if (all([](const auto& o) { return o.durability >= 1; }))
    qos.durability = Durability::kTransientLocal;
  return qos;
}

std::vector<QosMismatch> qos_mismatches(const Policies& offered, const Policies& requested) {
  std::vector<QosMismatch> found;
  compare("reliability", kReliabilities, offered.reliability, requested.reliability, found);
  compare("durability", kDurabilities, offered.durability, requested.durability, found);
  if (offered.deadline > requested.deadline)
    found.push_back({"deadline", in_seconds(offered.deadline), in_seconds(requested.deadline)});
  compare("liveliness", kLivelinesses, offered.liveliness, requested.liveliness, found);
  return found;
}

std::string override_for(const QosMismatch& mismatch, bool at_subscription) {
  std::string value = at_subscription ? mismatch.offered : mismatch.requested;
  std::replace(value.begin(), value.end(), ' ', '_');
  const bool settable = value == "best_effort" || value == "reliable" || value == "volatile" ||
                        value == "transient_local";
  return settable ? mismatch.policy + ": " + value : "";
}

}  // namespace tandem::runtime
