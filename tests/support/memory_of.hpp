// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <fstream>
#include <string>

#include "support/instrumented.hpp"

namespace tandem::test {

/// Memory [MB] that a process uses now ("VmRSS") or used at its peak ("VmHWM").
[[nodiscard]] inline double memory_of(pid_t process, const std::string& which = "VmRSS") {
  std::ifstream status{"/proc/" + std::to_string(process) + "/status"};
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(which + ":")) return 1.024e-3 * std::stod(line.substr(which.size() + 1));
  return 0.0;
}

/// An upper bound on memory [MB]. Infinite under a sanitizer, which holds on to freed memory.
constexpr double most_memory(double megabytes) { return kInstrumented ? 1e6 : megabytes; }

}  // namespace tandem::test
