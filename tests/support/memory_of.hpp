// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <fstream>
#include <string>

#include "support/instrumented.hpp"

namespace tandem::test {

/// [MB] that a process holds ("VmRSS") or held at most ("VmHWM").
[[nodiscard]] inline double memory_of(pid_t process, const std::string& which = "VmRSS") {
  std::ifstream status{"/proc/" + std::to_string(process) + "/status"};
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(which + ":")) return 1.024e-3 * std::stod(line.substr(which.size() + 1));
  return 0.0;
}

/// A bound on memory [MB], none under a sanitizer, which keeps what is freed.
constexpr double most_memory(double megabytes) { return kInstrumented ? 1e6 : megabytes; }

}  // namespace tandem::test
