// SPDX-License-Identifier: Apache-2.0
// Finds the known name that a misspelled one was probably meant to be, for error messages.
#pragma once

#include <set>
#include <string>

namespace tandem {

/// The name with the smallest edit distance to `word`; empty if none is close enough.
[[nodiscard]] std::string nearest_name(const std::string& word, const std::set<std::string>& names);

/// "; did you mean `name`?" with the nearest of `names`; empty if none is close enough.
[[nodiscard]] std::string did_you_mean(const std::string& word, const std::set<std::string>& names);

}  // namespace tandem
