// SPDX-License-Identifier: Apache-2.0
// In: one step done after the other. Out: how far it is and how long it still takes, on standard
// error.
#pragma once

#include <cstddef>
#include <string>

namespace tandem {

/// On a terminal one line that is written over; else a line now and then, fit for a log.
class ProgressBar {
 public:
  /// `unit`: of what there are so many in `all`; `before` of them were done before.
  ProgressBar(std::size_t all, std::size_t before, std::string unit);

  void step(const std::string& note);
  /// Before other text, where both go to one terminal.
  void clear() const;

 private:
  [[nodiscard]] std::string line(double t, const std::string& note) const;

  std::size_t all_, before_, now_ = 0;
  std::string unit_;
  bool terminal_;
  double start_, next_;  // [s]
};

}  // namespace tandem
