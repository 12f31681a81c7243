// SPDX-License-Identifier: Apache-2.0
// Reads or generates the access token of web clients.
#pragma once

#include <string>

namespace tandem {

/// The first line of a file. The token is not passed as a parameter or argument, because everybody
/// can read those. Throws std::invalid_argument with one line if there is no such file, or if that
/// line is not 12 to 128 letters, digits, - and _.
[[nodiscard]] std::string token_from(const std::string& path);

/// A new token: 128 random bits in hexadecimal.
[[nodiscard]] std::string new_token();

}  // namespace tandem
