// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/access_token.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <random>
#include <stdexcept>

namespace tandem {
namespace {

constexpr std::size_t kShortest = 12, kLongest = 128;
constexpr std::size_t kDigits = 32;  // hexadecimal digits, 4 bits each

bool fits_an_address(unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; }

}  // namespace

std::string token_from(const std::string& path) {
  std::ifstream file{path};
  std::string token;
  if (!file || !std::getline(file, token))
    throw std::invalid_argument("token_file = \"" + path +
                                "\" is not readable or is empty: its first line must be the token");
  if (token.size() < kShortest || token.size() > kLongest ||
      !std::all_of(token.begin(), token.end(), fits_an_address))
    throw std::invalid_argument(
        "token_file = \"" + path +
        "\": the first line must consist of 12 to 128 letters, digits, - and _");
  return token;
}

std::string new_token() {
  std::random_device random;
  std::string token;
  while (token.size() < kDigits) token.push_back("0123456789abcdef"[random() % 16]);
  return token;
}

}  // namespace tandem
