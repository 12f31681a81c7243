// SPDX-License-Identifier: Apache-2.0
// Lists all parameter names and suggests the closest one for a misspelled name.
#pragma once

#include <set>
#include <string>

#include "bringup/system/component_params.hpp"
#include "tandem/config/nearest_name.hpp"

namespace tandem {

/// The names of all parameters of all components.
inline const std::set<std::string>& parameter_names() {
  static const auto names = [] {
    std::set<std::string> all{"use_sim_time"};  // declared by the runtime
    const auto add = [&](const char* name, const auto&...) { all.insert(name); };
    for_each_component([&](const char*, auto params) { params.visit(add); });
    return all;
  }();
  return names;
}

/// Whether a component is one of ours. Other components may use a retired parameter name.
inline bool is_our_component(const std::string& component) {
  bool is_ours = false;
  for_each_component(
      [&](const char* name, const auto&) { is_ours = is_ours || component == name; });
  return is_ours;
}

/// The parameter name closest to a word; empty if none is close enough.
inline std::string nearest_parameter(const std::string& word) {
  return nearest_name(word, parameter_names());
}

}  // namespace tandem
