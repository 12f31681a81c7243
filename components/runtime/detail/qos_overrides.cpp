// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/qos_overrides.hpp"

#include <memory>

namespace tandem::runtime {
namespace {

struct QosParams {
  std::string prefix;  // "qos_overrides./odom.publisher."
  std::string reliability, durability;
  int depth;

  template <class Visitor>
  void visit(Visitor&& field) {
    field((prefix + "reliability").c_str(), reliability, OneOf{{"reliable", "best_effort"}},
          "whether lost samples are retransmitted");
    field((prefix + "durability").c_str(), durability, OneOf{{"volatile", "transient_local"}},
          "whether late subscriptions receive earlier samples");
    field((prefix + "depth").c_str(), depth, Range{1.0, 10'000.0}, "number of samples kept");
  }
};

}  // namespace

std::string qos_prefix(const std::string& topic, const std::string& kind) {
  return "qos_overrides." + topic + "." + kind;
}

struct QosOverrides::Applied {
  QoS first;  // the QoS before the override, at the first call
  std::shared_ptr<const QosParams> params;
};

QoS QosOverrides::apply(const QoS& qos, const std::string& topic, const std::string& kind) {
  const std::string prefix = qos_prefix(topic, kind) + ".";
  if (!store_.gives_any(prefix)) return qos;
  auto& applied = applied_[prefix];
  if (!applied) {
    const bool reliable = qos.reliability == Reliability::kReliable;
    const bool latched = qos.durability == Durability::kTransientLocal;
    const auto params =
        std::make_shared<QosParams>(QosParams{prefix, reliable ? "reliable" : "best_effort",
                                              latched ? "transient_local" : "volatile", qos.depth});
    params->visit(store_);
    parameters_.declare(make_fixed_group(params));
    applied = std::make_shared<const Applied>(Applied{qos, params});
  }
  const auto& [first, params] = *applied;
  QoS wanted = qos;
  wanted.reliability =
      params->reliability == "reliable" ? Reliability::kReliable : Reliability::kBestEffort;
  wanted.depth = params->depth;
  if (qos.durability == first.durability)
    wanted.durability = params->durability == "transient_local" ? Durability::kTransientLocal
                                                                : Durability::kVolatile;
  return wanted;
}

}  // namespace tandem::runtime
