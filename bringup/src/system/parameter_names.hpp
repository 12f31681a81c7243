// SPDX-License-Identifier: Apache-2.0
// Lists all parameter names and suggests the closest one for a misspelled name.
#pragma once

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bringup/system/component_params.hpp"

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

/// Edit distance (Levenshtein 1966): insertions, deletions and replacements of one letter,
/// computed row by row.
inline std::size_t letters_apart(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t before = std::exchange(row[0], i + 1);  // of the row above, one to the left
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = before + (a[i] == b[j] ? 0 : 1);
      before = std::exchange(row[j + 1], std::min({row[j] + 1, row[j + 1] + 1, replaced}));
    }
  }
  return row.back();
}

/// The parameter name closest to a word; empty if none is close enough.
inline std::string nearest_parameter(const std::string& word) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const auto& name : parameter_names())
    if (const std::size_t apart = letters_apart(word, name); apart < least)
      least = apart, nearest = name;
  return nearest;
}

}  // namespace tandem
