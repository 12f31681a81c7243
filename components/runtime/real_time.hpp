// SPDX-License-Identifier: Apache-2.0
// Real-time priorities of a process's threads.
#pragma once

#include <string>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Gives the calling thread a real-time priority (Linux's SCHED_FIFO, 1 to 99): it runs before all
/// threads without one. Threads that it starts do not inherit it. If the system refuses, the thread
/// stays as it is, and the refusal is logged with its remedy. `thread`: what the log calls it.
TANDEM_EXPORT void use_real_time(const std::string& thread, int priority);

/// Has the threads of every DDS participant that this process makes from now on run with a
/// real-time priority, with refusals as above; 0: none, as at the start. They receive all messages
/// from other processes. Thread-safe.
TANDEM_EXPORT void use_real_time_for_dds(int priority);

}  // namespace tandem::runtime
