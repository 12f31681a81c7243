// SPDX-License-Identifier: Apache-2.0
// Converts between QoS profiles and the YAML that rosbag2 stores with each recorded topic.
#pragma once

#include <string>

#include "tandem/runtime/qos.hpp"

namespace YAML {
class Emitter;
}

namespace tandem {

/// How policies are written: until Iron as rmw's numbers, from Jazzy (metadata version 9) as words.
enum class QosForm { kNumbers, kWords };

/// Appends the list of the one profile, for `offered_qos_profiles`.
void emit_qos(YAML::Emitter& out, const rt::QoS& qos, QosForm form);

/// The same as text.
[[nodiscard]] std::string qos_yaml(const rt::QoS& qos, QosForm form);

/// The profile for one publisher that replaces all listed ones: the strongest offer of any of them
/// and, on a latched topic, a depth equal to the sum of theirs. If the recording lists no profiles,
/// the result matches any subscription.
[[nodiscard]] rt::QoS recorded_qos(const std::string& topic, const std::string& yaml);

}  // namespace tandem
