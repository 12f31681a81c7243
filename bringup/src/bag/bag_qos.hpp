// SPDX-License-Identifier: Apache-2.0
// The QoS profiles that a recording keeps with each topic, as rosbag2 writes and reads them.
#pragma once

#include <string>

#include "tandem/runtime/qos.hpp"

namespace tandem {

/// The profile as YAML, for `offered_qos_profiles`.
[[nodiscard]] std::string qos_yaml(const rt::QoS& qos);

/// What to offer in place of all publishers whose profiles are listed: the most that one of them
/// offers and, on a latched topic, as many messages as all of them keep. A recording that does not
/// say is offered so that any subscription matches.
[[nodiscard]] rt::QoS recorded_qos(const std::string& topic, const std::string& yaml);

}  // namespace tandem
