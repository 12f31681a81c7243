// SPDX-License-Identifier: Apache-2.0
// Shows on standard error how many steps of a task are done and how long the rest will take.
#pragma once

#include <cstddef>
#include <string>

namespace tandem {

/// On a terminal, overwrites one line; otherwise prints a line every 10 s, as suits a log.
class ProgressBar {
 public:
  /// `all`: number of steps; `before`: those finished in earlier runs; `unit`: plural noun for the
  /// steps.
  ProgressBar(std::size_t all, std::size_t before, std::string unit);

  void step(const std::string& note);
  /// Clears the line, so that other text can be printed to the same terminal.
  void clear() const;

 private:
  [[nodiscard]] std::string line(double t, const std::string& note) const;

  std::size_t all_, before_, now_ = 0;
  std::string unit_;
  bool terminal_;
  double start_, next_;  // [s]
};

}  // namespace tandem
