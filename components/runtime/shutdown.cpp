// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/shutdown.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include <unistd.h>

#include "tandem/runtime/detail/node_core.hpp"
#include "tandem/runtime/detail/running_nodes.hpp"

namespace tandem::runtime {
namespace {

struct Process {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<NodeCore*> nodes;
  bool down = false;
};

// Never destroyed: the signal thread may outlive main().
Process& process() {
  static auto* instance = new Process;
  return *instance;
}

int signal_pipe[2] = {-1, -1};
std::atomic<int> signals_seen = 0;
static_assert(std::atomic<int>::is_always_lock_free);  // required in a signal handler

// Only async-signal-safe calls.
extern "C" void on_signal(int number) {
  if (signals_seen.fetch_add(1) > 0) {
    if (number == SIGHUP) return;  // shell and kernel may each send one
    _exit(128 + number);
  }
  const int saved = errno;
  const char byte = 0;
  if (write(signal_pipe[1], &byte, 1) < 0) _exit(128 + number);
  errno = saved;
}

void wait_for_signal() {
  char byte;
  while (::read(signal_pipe[0], &byte, 1) < 0 && errno == EINTR) {
  }
  shutdown();
}

}  // namespace

void install_signal_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (pipe(signal_pipe) != 0) throw std::runtime_error("cannot create a pipe for signals");
    std::thread{wait_for_signal}.detach();
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    struct sigaction before {};
    sigaction(SIGHUP, nullptr, &before);  // keep it ignored if started by nohup
    if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
  });
}

void shutdown() {
  auto& all = process();
  const std::lock_guard lock{all.mutex};
  all.down = true;
  for (auto* node : all.nodes) node->stop();
  all.changed.notify_all();
}

bool shutting_down() {
  const std::lock_guard lock{process().mutex};
  return process().down;
}

void wait_for_shutdown() {
  std::unique_lock lock{process().mutex};
  process().changed.wait(lock, [] { return process().down; });
}

bool wait_for_shutdown(double max_wait) {
  std::unique_lock lock{process().mutex};
  return process().changed.wait_for(lock, std::chrono::duration<double>(max_wait),
                                    [] { return process().down; });
}

void running_nodes::add(NodeCore& node) {
  auto& all = process();
  const std::lock_guard lock{all.mutex};
  all.nodes.push_back(&node);
  if (all.down) node.stop();
}

void running_nodes::remove(NodeCore& node) {
  auto& all = process();
  const std::lock_guard lock{all.mutex};
  std::erase(all.nodes, &node);
}

}  // namespace tandem::runtime
