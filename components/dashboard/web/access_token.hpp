// SPDX-License-Identifier: Apache-2.0
// In: a file, or nothing. Out: the secret that web clients have to know.
#pragma once

#include <string>

namespace tandem {

/// The first line of a file. A file, not a parameter, for parameters are everybody's to read, and
/// so are the arguments of a process. Throws std::invalid_argument in one line if there is no such
/// file, or if that line is not 12 to 128 letters, digits, - and _.
[[nodiscard]] std::string token_from(const std::string& path);

/// 128 random bits, hexadecimal.
[[nodiscard]] std::string new_token();

}  // namespace tandem
