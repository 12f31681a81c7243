// SPDX-License-Identifier: Apache-2.0
// In: JSON from a file or a client. Out: its value, nested no deeper than code that recurses
// stands.
#pragma once

#include <istream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace tandem {

/// Throws std::invalid_argument if arrays and objects are nested deeper than 64 levels: copying and
/// writing a value recurse, and 10⁵ levels overflow the stack. The text need not be JSON.
inline void check_json_depth(std::string_view text) {
  constexpr int kMaxDepth = 64;
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"')
      quoted = !quoted;
    else if (quoted)
      i += c == '\\' ? 1 : 0;
    else if (c == '[' || c == '{')
      ++depth;
    else if (c == ']' || c == '}')
      --depth;
    if (depth > kMaxDepth) throw std::invalid_argument("JSON nested deeper than 64 levels");
  }
}

/// Throws Json::exception for what is no JSON and std::invalid_argument for a value nested deeper
/// than 64 levels. Takes time in proportion to the text: the library's own parser with a callback
/// looks at all elements of an array again after each object in it.
template <class Json = nlohmann::json>
[[nodiscard]] Json parse_json(std::string_view text) {
  check_json_depth(text);
  return Json::parse(text);
}
template <class Json = nlohmann::json>
[[nodiscard]] Json parse_json(std::istream& file) {
  return parse_json<Json>(std::string{std::istreambuf_iterator<char>{file}, {}});
}

/// The same, null for what is no JSON or nested too deep.
template <class Json = nlohmann::json, class Input>
[[nodiscard]] Json parse_json_or_null(Input&& input) {
  try {
    return parse_json<Json>(input);
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace tandem
