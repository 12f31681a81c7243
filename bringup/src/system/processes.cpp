// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/processes.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

#include "bringup/system/service_manager.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

constexpr double kPatience = 2.0;      // [s] between SIGTERM and SIGKILL
constexpr double kPollPeriod = 0.05;   // [s] between checks for ended children
constexpr double kHealthyStart = 5.0;  // [s] exiting earlier indicates a configuration error
constexpr double kAlivePeriod = 1.0;   // [s] between reports to the service manager
constexpr double kStarted = -1.0;      // [s] start time that marks a pending process as started

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

// Runs in the forked child, where other threads' locks may be held: only system calls are safe.
[[noreturn]] void become(char* const* argv, pid_t parent) {
  setpgid(0, 0);  // Ctrl-C reaches this process only, which then ends its children in order
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(EXIT_FAILURE);  // the parent died before prctl()
  execv("/proc/self/exe", argv);
  _exit(127);
}

}  // namespace

double respawn_delay(double last, double life) {
  constexpr double kShortest = 0.5, kLongest = 30.0, kHealthy = 60.0;  // [s]
  return life >= kHealthy ? kShortest : std::clamp(2.0 * last, kShortest, kLongest);
}

void Processes::start(const ProcessPlan& plan) { launch(plan, plan.arguments, 0.0); }

void Processes::launch(const ProcessPlan& plan, const std::vector<std::string>& arguments,
                       double delay) {
  std::vector<std::string> words{"tandem"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0)
    throw std::runtime_error("no process for " + plan.name + ": " + std::strerror(errno));
  if (pid == 0) become(argv.data(), parent);
  children_.push_back({plan, pid, rt::steady_seconds(), delay});
}

void Processes::reap(bool expected) {
  std::erase_if(children_, [&](const Child& child) {
    int status = 0;
    if (waitpid(child.pid, &status, WNOHANG) != child.pid) return false;
    if (!expected && child.plan.respawn && !failed_at_once(child, status))
      plan_respawn(child, how(status));
    else if (!expected || status != 0)
      log().error("{} (process {}) {}", child.plan.name, child.pid, how(status));
    return true;
  });
}

// A wrong parameter or a missing file needs the user; respawning does not help.
bool Processes::failed_at_once(const Child& child, int status) {
  const bool is_first = child.delay == 0.0;
  return is_first && WIFEXITED(status) && rt::steady_seconds() - child.start < kHealthyStart;
}

void Processes::plan_respawn(const Child& child, const std::string& how) {
  const double now = rt::steady_seconds();
  const double delay = respawn_delay(child.delay, now - child.start);
  log().error("{} (process {}) {}; it starts again in {:.1f} s", child.plan.name, child.pid, how,
              delay);
  pending_.push_back({child.plan, now + delay, delay});
}

// A process that cannot be created now (process limit, no memory) is retried later.
void Processes::start_pending() {
  const double now = rt::steady_seconds();
  for (auto& pending : pending_) {
    if (now < pending.start) continue;
    std::vector<std::string> arguments = pending.plan.arguments;
    const auto& added = pending.plan.respawn_arguments;
    arguments.insert(arguments.end(), added.begin(), added.end());
    try {
      launch(pending.plan, arguments, pending.delay);
      pending.start = kStarted;
    } catch (const std::runtime_error& error) {
      pending.delay = respawn_delay(pending.delay, 0.0);
      pending.start = now + pending.delay;
      log().error("{}; the next try is in {:.1f} s", error.what(), pending.delay);
    }
  }
  std::erase_if(pending_, [](const Pending& pending) { return pending.start == kStarted; });
}

int Processes::run() {
  notify_service_manager("READY=1");
  double reported = rt::steady_seconds();
  while (!children_.empty() || !pending_.empty()) {
    if (rt::wait_for_shutdown(kPollPeriod)) {
      notify_service_manager("STOPPING=1");
      return died_ ? 1 : 0;
    }
    if (const double now = rt::steady_seconds(); now - reported >= kAlivePeriod) {
      notify_service_manager("WATCHDOG=1");
      reported = now;
    }
    start_pending();
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
