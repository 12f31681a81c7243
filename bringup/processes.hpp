// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace tandem {

/// Child processes that run this program. None outlives this process, however it ends.
class Processes {
 public:
  Processes() = default;
  ~Processes();  ///< SIGTERM for all that are left, SIGKILL two seconds later, and reaped
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  /// Starts `<this program> arguments...`; `name` is what the log calls it. Throws
  /// std::runtime_error if the process cannot be made.
  void start(const std::string& name, const std::vector<std::string>& arguments);

  /// Watches the children until a shutdown (SIGINT, SIGTERM) or until none is left; each death is
  /// logged and the others run on. The exit status: 0 after a shutdown, 1 if one died by itself.
  int run();

 private:
  struct Child {
    std::string name;
    pid_t pid;
  };

  void reap(bool expected);

  std::vector<Child> children_;
  bool died_ = false;  // one of them, unasked
};

}  // namespace tandem
