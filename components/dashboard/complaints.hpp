// SPDX-License-Identifier: Apache-2.0
// Collects the errors in one frame of a client into one message.
#pragma once

#include <cstddef>
#include <string>

namespace tandem {

class Complaints {
 public:
  /// Adds an error; an empty string is ignored.
  void add(const std::string& what) {
    if (what.empty()) return;
    if (count_++ == 0) first_ = what;
  }
  /// The first error and the number of others; empty without errors.
  [[nodiscard]] std::string text() const {
    if (count_ < 2) return first_;
    return first_ + " (and " + std::to_string(count_ - 1) + " more in the same request)";
  }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

}  // namespace tandem
