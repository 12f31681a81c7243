// SPDX-License-Identifier: Apache-2.0
// Parses JSON from files and clients, with a limit on nesting that recursive code can handle.
#pragma once

#include <istream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace tandem {

/// Throws std::invalid_argument if arrays and objects are nested deeper than 64 levels: copying and
/// writing a value recurse, and 10⁵ levels overflow the stack. Accepts any text, JSON or not.
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

/// Throws Json::exception if the text is not JSON and std::invalid_argument if it is nested deeper
/// than 64 levels. Takes linear time; the library's own parser with a callback revisits all
/// elements of an array after each object in it.
template <class Json = nlohmann::json>
[[nodiscard]] Json parse_json(std::string_view text) {
  check_json_depth(text);
  return Json::parse(text);
}
template <class Json = nlohmann::json>
[[nodiscard]] Json parse_json(std::istream& file) {
  return parse_json<Json>(std::string{std::istreambuf_iterator<char>{file}, {}});
}

/// As parse_json, but returns null if the text is not JSON or nested too deep.
template <class Json = nlohmann::json, class Input>
[[nodiscard]] Json parse_json_or_null(Input&& input) {
  try {
    return parse_json<Json>(input);
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace tandem
