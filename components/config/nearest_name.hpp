// SPDX-License-Identifier: Apache-2.0
// Finds the known name that a misspelled one is closest to, for error messages.
#pragma once

#include <algorithm>
#include <string>

namespace tandem {

/// Edit distance (Levenshtein 1966): insertions, deletions and replacements of one letter.
[[nodiscard]] std::size_t letters_apart(const std::string& a, const std::string& b);

/// The name in `names` closest to `word`; empty if none is close enough to be meant.
template <class Names>
[[nodiscard]] std::string nearest_name(const std::string& word, const Names& names) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& name : names)
    if (const std::size_t apart = letters_apart(word, name); apart < least)
      least = apart, nearest = name;
  return nearest;
}

/// "; did you mean `name`?" with the nearest of `names`; empty if none is close enough.
template <class Names>
[[nodiscard]] std::string did_you_mean(const std::string& word, const Names& names) {
  const std::string nearest = nearest_name(word, names);
  return nearest.empty() ? "" : "; did you mean `" + nearest + "`?";
}

}  // namespace tandem
