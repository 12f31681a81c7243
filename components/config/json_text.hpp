// SPDX-License-Identifier: Apache-2.0
// In: JSON from a file or a client. Out: its value, nested no deeper than code that recurses
// stands.
#pragma once

#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

namespace tandem {

/// Throws Json::exception for what is no JSON and std::invalid_argument for a value nested deeper
/// than 64 levels: copying and writing a value recurse, and 10⁵ levels overflow the stack.
template <class Json = nlohmann::json, class Input>
[[nodiscard]] Json parse_json(Input&& input) {
  constexpr int kMaxDepth = 64;
  const auto is_shallow = [](int depth, typename Json::parse_event_t, Json&) {
    if (depth > kMaxDepth) throw std::invalid_argument("JSON nested deeper than 64 levels");
    return true;
  };
  return Json::parse(std::forward<Input>(input), is_shallow);
}

/// The same, null for what is no JSON or nested too deep.
template <class Json = nlohmann::json, class Input>
[[nodiscard]] Json parse_json_or_null(Input&& input) {
  try {
    return parse_json<Json>(std::forward<Input>(input));
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace tandem
