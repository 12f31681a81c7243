// SPDX-License-Identifier: Apache-2.0
#include "tandem/config/nearest_name.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace tandem {
namespace {

// Edit distance (Levenshtein 1966): insertions, deletions and replacements of one letter, computed
// row by row.
std::size_t letters_apart(const std::string& a, const std::string& b) {
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

}  // namespace

std::string nearest_name(const std::string& word, const std::set<std::string>& names) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const auto& name : names)
    if (const std::size_t apart = letters_apart(word, name); apart < least)
      least = apart, nearest = name;
  return nearest;
}

std::string did_you_mean(const std::string& word, const std::set<std::string>& names) {
  const std::string nearest = nearest_name(word, names);
  return nearest.empty() ? "" : "; did you mean `" + nearest + "`?";
}

}  // namespace tandem
