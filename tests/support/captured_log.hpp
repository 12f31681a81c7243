// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>
#include <string>

namespace tandem::test {

/// Captures what this process and its children write to stderr during this object's lifetime; the
/// destructor writes it to the real stderr.
class CapturedLog {
 public:
  CapturedLog() : stderr_{dup(STDERR_FILENO)}, file_{memfd_create("log", MFD_CLOEXEC)} {
    if (stderr_ < 0 || file_ < 0 || dup2(file_, STDERR_FILENO) < 0)
      throw std::runtime_error("stderr cannot be captured");
  }
  ~CapturedLog() {
    dup2(stderr_, STDERR_FILENO);
    std::fputs(text().c_str(), stderr);
    close(stderr_);
    close(file_);
  }
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;

  [[nodiscard]] std::string text() const {
    std::string all;
    char part[4096];
    for (ssize_t size = 1; size > 0; all.append(part, static_cast<std::size_t>(size))) {
      size = pread(file_, part, sizeof part, static_cast<off_t>(all.size()));
      if (size <= 0) break;
    }
    return all;
  }

  /// Number of lines that contain `what`.
  [[nodiscard]] int lines(const std::string& what) const {
    const std::string all = text();
    int count = 0;
    for (std::size_t at = all.find(what); at != std::string::npos; ++count) {
      const auto end = all.find('\n', at);
      at = end == std::string::npos ? end : all.find(what, end);
    }
    return count;
  }

 private:
  int stderr_, file_;
};

}  // namespace tandem::test
