// SPDX-License-Identifier: Apache-2.0
// Lists the topics and services of each component, for `tandem describe` and for permissions.
#pragma once

#include <string>
#include <vector>

namespace tandem {

/// Relative names, as in topics.hpp, used with any parameter values; "*" means all names.
struct ComponentTopics {
  std::vector<const char*> subscribes{}, publishes{};  ///< topics
  std::vector<const char*> serves{}, calls{};          ///< services
  const char* other_input = "";  ///< inputs other than topics, as text for the user
  const char* other_output = "";
};

/// Throws std::invalid_argument if the component is not one of ours.
[[nodiscard]] const ComponentTopics& topics_of(const std::string& component);

/// Names that every node uses in addition: log, parameters and clock.
[[nodiscard]] const ComponentTopics& topics_of_any_node();

}  // namespace tandem
