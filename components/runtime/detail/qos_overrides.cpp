// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/qos_overrides.hpp"

#include <memory>

namespace tandem::runtime {
namespace {

struct QosParams {
  std::string prefix;  // "qos_overrides./odom.publisher."
  std::string reliability, durability;
  int depth;
  std::string history = "keep_last";

  template <class Visitor>
  void visit(Visitor&& field) {
    field((prefix + "reliability").c_str(), reliability, OneOf{{"reliable", "best_effort"}},
          "whether lost samples are retransmitted");
    field((prefix + "durability").c_str(), durability, OneOf{{"volatile", "transient_local"}},
          "whether late subscriptions receive earlier samples");
    field((prefix + "depth").c_str(), depth, Range{1.0, 10'000.0}, "number of samples kept");
    field((prefix + "history").c_str(), history, OneOf{{"keep_last"}}, "which samples are kept");
  }
};

QosParams params_of(const QoS& qos, const std::string& prefix) {
  return {prefix, qos.reliability == Reliability::kReliable ? "reliable" : "best_effort",
          qos.durability == Durability::kTransientLocal ? "transient_local" : "volatile",
          qos.depth};
}

}  // namespace

std::string qos_prefix(const std::string& topic, const std::string& kind) {
  return "qos_overrides." + topic + "." + kind;
}

struct QosOverrides::Applied {
  QoS first, wanted;  // before and after the overrides, at the first call
};

QoS QosOverrides::apply(const QoS& qos, const std::string& topic, const std::string& kind) {
  const std::string prefix = qos_prefix(topic, kind) + ".";
  auto& applied = applied_[prefix];
  if (!applied) applied = std::make_shared<const Applied>(Applied{qos, declare(qos, prefix)});
  const auto& [first, wanted] = *applied;
  QoS tuned = qos;
  if (wanted.reliability != first.reliability) tuned.reliability = wanted.reliability;
  if (wanted.depth != first.depth) tuned.depth = wanted.depth;
  if (wanted.durability != first.durability && qos.durability == first.durability)
    tuned.durability = wanted.durability;
  return tuned;
}

std::string QosOverrides::prefix_of(const std::string& topic, const std::string& kind) const {
  const std::string prefix = qos_prefix(topic, kind);
  return applied_.contains(prefix + ".") ? prefix : "";
}

QoS QosOverrides::declare(const QoS& qos, const std::string& prefix) {
  const auto params = std::make_shared<QosParams>(params_of(qos, prefix));
  params->visit(store_);
  parameters_.declare(make_fixed_group(params));
  QoS wanted = qos;
  wanted.reliability =
      params->reliability == "reliable" ? Reliability::kReliable : Reliability::kBestEffort;
  wanted.durability =
      params->durability == "transient_local" ? Durability::kTransientLocal : Durability::kVolatile;
  wanted.depth = params->depth;
  return wanted;
}

}  // namespace tandem::runtime
