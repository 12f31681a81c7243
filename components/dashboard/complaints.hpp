// SPDX-License-Identifier: Apache-2.0
// One sentence for a client about all that is wrong with one frame of its.
#pragma once

#include <cstddef>
#include <string>

namespace tandem {

class Complaints {
 public:
  /// Empty: nothing is wrong.
  void add(const std::string& what) {
    if (what.empty()) return;
    if (count_++ == 0) first_ = what;
  }
  /// The first one, and how many more there are; empty: there are none.
  [[nodiscard]] std::string text() const {
    if (count_ < 2) return first_;
    return first_ + " (and " + std::to_string(count_ - 1) + " more in the same request)";
  }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

}  // namespace tandem
