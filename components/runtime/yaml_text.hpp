// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace YAML {
class Node;
}

namespace tandem::runtime {

/// A value as YAML text in one line, for ParameterValue; unlike YAML::Dump it keeps quotes.
[[nodiscard]] std::string yaml_text(const YAML::Node& value);

}  // namespace tandem::runtime
