// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/real_time.hpp"

#include <sys/resource.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "tandem/runtime/detail/priority_of_dds.hpp"
#include "tandem/runtime/log.hpp"

namespace tandem::runtime {
namespace {

std::atomic<int> dds_priority = 0;

// sched_setscheduler() acts on one thread, in spite of its name; 0 is the calling one.
bool set_policy(int policy, int priority) {
  sched_param param{};
  param.sched_priority = priority;
  return sched_setscheduler(0, policy, &param) == 0;
}

void report_refusal(const std::string& thread, int priority, int error) {
  rlimit limit{};
  getrlimit(RLIMIT_RTPRIO, &limit);
  Logger{"runtime"}.warn(
      "thread {} has no real-time priority {}: {}; the highest that this user may use is {}. Raise "
      "it with `ulimit -r {}`, with rtprio in /etc/security/limits.conf, or in a systemd unit with "
      "LimitRTPRIO={} and RestrictRealtime=no",
      thread, priority, std::strerror(error), limit.rlim_cur, priority, priority);
}

}  // namespace

void use_real_time(const std::string& thread, int priority) {
  if (!set_policy(SCHED_FIFO | SCHED_RESET_ON_FORK, priority))
    report_refusal(thread, priority, errno);
}

void use_real_time_for_dds(int priority) { dds_priority = priority; }

int priority_of_dds() { return dds_priority; }

void use_real_time_with_children(int priority) {
  if (!set_policy(SCHED_FIFO, priority)) report_refusal("dds", priority, errno);
}

}  // namespace tandem::runtime
