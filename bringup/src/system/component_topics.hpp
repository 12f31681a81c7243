// SPDX-License-Identifier: Apache-2.0
// Which topics and services each component uses, for `tandem describe` and for permissions.
#pragma once

#include <string>
#include <vector>

namespace tandem {

/// Relative names, as in topics.hpp, for all values of the parameters; "*" stands for all.
struct ComponentTopics {
  std::vector<const char*> subscribes{}, publishes{};  ///< topics
  std::vector<const char*> serves{}, calls{};          ///< services
  const char* other_input = "";                        ///< what is no topic, for people
  const char* other_output = "";
};

/// Throws std::invalid_argument for what is none of our components.
[[nodiscard]] const ComponentTopics& topics_of(const std::string& component);

/// What each node uses besides: its log, its parameters, its clock.
[[nodiscard]] const ComponentTopics& topics_of_any_node();

}  // namespace tandem
