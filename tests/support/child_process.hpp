// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "tandem/runtime/time.hpp"

namespace tandem::test {

/// Child processes of `pid` that have not been reaped.
[[nodiscard]] inline std::vector<pid_t> children_of(pid_t pid) {
  std::ifstream file{"/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) + "/children"};
  std::vector<pid_t> pids;
  for (pid_t child = 0; file >> child;) pids.push_back(child);
  return pids;
}

/// Runs a program from the tests' build folder, or one given by its full path; the destructor kills
/// it.
class ChildProcess {
 public:
  ChildProcess(const std::string& program, std::vector<std::string> arguments) {
    std::string path = program.starts_with("/") ? program : folder() + "/" + program;
    std::vector<char*> argv{path.data()};
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ < 0) throw std::system_error(errno, std::generic_category(), path);
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      execv(path.c_str(), argv.data());
      _exit(127);
    }
  }
  ~ChildProcess() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void send(int signal_number) const {
    if (pid_ > 0) kill(pid_, signal_number);  // kill(-1) would reach every process
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

  /// Exit status if the process ends within `timeout` [s]; 128 + n if signal n killed it.
  [[nodiscard]] std::optional<int> wait(double timeout) {
    const double end = runtime::steady_seconds() + timeout;
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) != pid_) {
      if (runtime::steady_seconds() > end) return std::nullopt;
      usleep(1000);
    }
    pid_ = -1;
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }

  [[nodiscard]] static std::string folder() {
    char path[4096];
    const auto size = readlink("/proc/self/exe", path, sizeof path);
    const std::string program(path, size > 0 ? static_cast<std::size_t>(size) : 0);
    return program.substr(0, program.rfind('/'));
  }

 private:
  pid_t pid_ = -1;
};

}  // namespace tandem::test
