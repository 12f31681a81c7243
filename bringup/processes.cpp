// SPDX-License-Identifier: Apache-2.0
#include "bringup/processes.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

#include "runtime/node.hpp"
#include "runtime/shutdown.hpp"

namespace tandem {
namespace {

constexpr double kPatience = 2.0;  // [s] between SIGTERM and SIGKILL
constexpr double kLook = 0.05;     // [s] between looks at who died

rt::Logger& log() {
  static rt::Logger logger{"tandem"};
  return logger;
}

std::string how(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("was killed by signal {} ({})", WTERMSIG(status),
                       strsignal(WTERMSIG(status)));
  return fmt::format("ended with status {}", WEXITSTATUS(status));
}

// In the child, where other threads' locks may be held: only system calls.
[[noreturn]] void become(char* const* argv, pid_t parent) {
  setpgid(0, 0);  // Ctrl-C reaches this process only, which then ends its children in order
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(EXIT_FAILURE);  // it died before the line above
  execv("/proc/self/exe", argv);
  _exit(127);
}

}  // namespace

void Processes::start(const std::string& name, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{"tandem"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("no process for " + name + ": " + std::strerror(errno));
  if (pid == 0) become(argv.data(), parent);
  children_.push_back({name, pid});
}

void Processes::reap(bool expected) {
  std::erase_if(children_, [&](const Child& child) {
    int status = 0;
    if (waitpid(child.pid, &status, WNOHANG) != child.pid) return false;
    if (!expected || status != 0)
      log().error("{} (process {}) {}", child.name, child.pid, how(status));
    return true;
  });
}

int Processes::run() {
  while (!children_.empty()) {
    if (rt::wait_for_shutdown(kLook)) return died_ ? 1 : 0;
    const std::size_t before = children_.size();
    reap(false);
    died_ = died_ || children_.size() < before;
  }
  log().error("no component is left");
  return 1;
}

Processes::~Processes() {
  for (const auto& child : children_) kill(child.pid, SIGTERM);
  const double end = rt::steady_seconds() + kPatience;
  while (!children_.empty() && rt::steady_seconds() < end) {
    reap(true);
    usleep(10'000);
  }
  for (const auto& child : children_) kill(child.pid, SIGKILL);
  for (const auto& child : children_) waitpid(child.pid, nullptr, 0);
}

}  // namespace tandem
