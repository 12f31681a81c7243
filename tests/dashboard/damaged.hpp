// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <span>
#include <string>

namespace tandem::test {

/// One of the texts with up to four damages: bytes changed, added, repeated, cut out or cut off.
inline std::string damaged(std::span<const std::string> texts, std::mt19937& random) {
  std::string text = texts[random() % texts.size()];
  for (auto damages = random() % 5; damages > 0 && !text.empty(); --damages) {
    const std::size_t at = random() % text.size(), size = random() % 8;
    switch (random() % 5) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.insert(at, size, static_cast<char>(random()));
        break;
      case 2:
        text.insert(at, text.substr(random() % text.size(), size));
        break;
      case 3:
        text.erase(at, size);
        break;
      default:
        text.resize(at);
    }
  }
  return text;
}

}  // namespace tandem::test
