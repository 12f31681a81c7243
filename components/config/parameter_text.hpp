// SPDX-License-Identifier: Apache-2.0
// Writes parameters as one text, for the keys of caches whose contents depend on them.
#pragma once

#include <ranges>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

namespace tandem {

/// "name=value;…" of all parameters, numbers with all their digits.
template <class Params>
[[nodiscard]] std::string parameter_text(Params params) {
  std::string text;
  params.visit([&](const char* name, const auto& value, const auto&...) {
    if constexpr (std::ranges::range<decltype(value)>)
      text += fmt::format("{}={};", name, fmt::join(value, ","));
    else
      text += fmt::format("{}={};", name, value);
  });
  return text;
}

}  // namespace tandem
