// SPDX-License-Identifier: Apache-2.0
// Converts between QoS profiles and the YAML that rosbag2 stores with each recorded topic.
#pragma once

#include <string>

#include "tandem/runtime/qos.hpp"

namespace tandem {

/// The profile as YAML, for `offered_qos_profiles`.
[[nodiscard]] std::string qos_yaml(const rt::QoS& qos);

/// The profile for one publisher that replaces all listed ones: the strongest offer of any of them
/// and, on a latched topic, a depth equal to the sum of theirs. If the recording lists no profiles,
/// the result matches any subscription.
[[nodiscard]] rt::QoS recorded_qos(const std::string& topic, const std::string& yaml);

}  // namespace tandem
