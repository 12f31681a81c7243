// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/bag_qos.hpp"

#include <algorithm>

#include <yaml-cpp/yaml.h>

#include "tandem/config/yaml_document.hpp"

namespace tandem {
namespace {

// The numbers rmw assigns to policies.
constexpr int kKeepLast = 1, kReliable = 1, kBestEffort = 2, kTransientLocal = 1, kVolatile = 2,
              kAutomatic = 1;
constexpr int kDeepest = 10'000;

// Each publisher's latched messages stay valid. A recorder lists only the publishers present when
// it subscribed; there may be more.
constexpr std::string_view kStaticTransforms = "/tf_static";
constexpr int kManyTransforms = 1000;

// Matches any subscription: the recording does not state which of its topics were latched.
constexpr rt::QoS kUnsaid{rt::Reliability::kReliable, rt::Durability::kTransientLocal,
                          rt::kDefault.depth};

void emit_duration(YAML::Emitter& out, const char* name) {
  out << YAML::Key << name << YAML::Value << YAML::BeginMap;  // rmw's notation for "unset"
  out << YAML::Key << "sec" << YAML::Value << 9223372036 << YAML::Key << "nsec" << YAML::Value
      << 854775807 << YAML::EndMap;
}

// Humble writes numbers, Jazzy writes words.
bool is(const YAML::Node& value, int number, const char* word) {
  return value &&
         (value.as<std::string>() == std::to_string(number) || value.as<std::string>() == word);
}

rt::QoS qos_of(const YAML::Node& profile) {
  rt::QoS qos;
  if (is(profile["reliability"], kBestEffort, "best_effort"))
    qos.reliability = rt::Reliability::kBestEffort;
  if (is(profile["durability"], kTransientLocal, "transient_local"))
    qos.durability = rt::Durability::kTransientLocal;
  // DDS discovery does not announce the depth: a recorder that does not know it writes 0.
  const int depth = profile["depth"].as<int>(0);
  if (depth > 0) qos.depth = std::min(depth, kDeepest);
  return qos;
}

// A profile that serves the subscriptions of both: a late subscriber gets the history of each.
rt::QoS together(const rt::QoS& a, const rt::QoS& b) {
  const bool latched = b.durability == rt::Durability::kTransientLocal;
  rt::QoS both = a;
  if (b.reliability == rt::Reliability::kReliable) both.reliability = b.reliability;
  if (latched) both.durability = b.durability;
  both.depth = latched ? std::min(a.depth + b.depth, kDeepest) : std::max(a.depth, b.depth);
  return both;
}

rt::QoS parse_qos(const std::string& yaml) {
  try {
    const YAML::Node profiles = parse_document(yaml);
    if (!profiles.IsSequence() || profiles.size() == 0) return kUnsaid;
    rt::QoS qos = qos_of(profiles[0]);
    for (std::size_t i = 1; i < profiles.size(); ++i) qos = together(qos, qos_of(profiles[i]));
    return qos;
  } catch (const YAML::Exception&) {
    return kUnsaid;
  }
}

}  // namespace

void emit_qos(YAML::Emitter& out, const rt::QoS& qos, QosForm form) {
  const auto policy = [&](const char* name, int number, const char* word) {
    out << YAML::Key << name << YAML::Value;
    form == QosForm::kNumbers ? out << number : out << word;
  };
  out << YAML::BeginSeq << YAML::BeginMap;
  policy("history", kKeepLast, "keep_last");
  out << YAML::Key << "depth" << YAML::Value << qos.depth;
  if (qos.reliability == rt::Reliability::kReliable)
    policy("reliability", kReliable, "reliable");
  else
    policy("reliability", kBestEffort, "best_effort");
  if (qos.durability == rt::Durability::kTransientLocal)
    policy("durability", kTransientLocal, "transient_local");
  else
    policy("durability", kVolatile, "volatile");
  emit_duration(out, "deadline");
  emit_duration(out, "lifespan");
  policy("liveliness", kAutomatic, "automatic");
  emit_duration(out, "liveliness_lease_duration");
  out << YAML::Key << "avoid_ros_namespace_conventions" << YAML::Value << false;
  out << YAML::EndMap << YAML::EndSeq;
}

std::string qos_yaml(const rt::QoS& qos, QosForm form) {
  YAML::Emitter out;
  emit_qos(out, qos, form);
  return out.c_str();
}

rt::QoS recorded_qos(const std::string& topic, const std::string& yaml) {
  rt::QoS qos = parse_qos(yaml);
  if (topic.ends_with(kStaticTransforms)) qos.depth = std::max(qos.depth, kManyTransforms);
  return qos;
}

}  // namespace tandem
