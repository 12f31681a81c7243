// SPDX-License-Identifier: Apache-2.0
// Real-time priorities of this process's threads.
#pragma once

#include <sched.h>

#include <filesystem>
#include <string>
#include <thread>

namespace tandem::test {

/// Whether this user may use low real-time priorities.
inline bool may_use_real_time() {
  sched_param param{};
  param.sched_priority = 3;
  bool may = false;
  std::thread{[&] { may = sched_setscheduler(0, SCHED_FIFO, &param) == 0; }}.join();
  return may;
}

/// How many threads of this process have this priority of SCHED_FIFO.
inline int threads_with_priority(int priority) {
  int count = 0;
  for (const auto& task : std::filesystem::directory_iterator{"/proc/self/task"}) {
    const pid_t id = std::stoi(task.path().filename());
    sched_param param{};
    sched_getparam(id, &param);
    const int policy = sched_getscheduler(id) & ~SCHED_RESET_ON_FORK;
    if (policy == SCHED_FIFO && param.sched_priority == priority) ++count;
  }
  return count;
}

}  // namespace tandem::test
