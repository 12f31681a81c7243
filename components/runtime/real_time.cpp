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

std::atomic<int> priority_of_dds = 0;

// sched_setscheduler() acts on one thread, in spite of its name; 0 is the calling one.
bool set_policy(int policy, int priority) {
  sched_param param{};
  param.sched_priority = priority;
  return sched_setscheduler(0, policy, &param) == 0;
}

void report_refusal(const std::string& thread, int priority, int error) {
  static std::atomic<bool> is_reported = false;
  if (is_reported.exchange(true)) return;
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

void use_real_time_for_dds(int priority) { priority_of_dds = priority; }

PriorityOfDds::PriorityOfDds() {
  const int priority = priority_of_dds;
  if (priority == 0) return;
  policy_ = sched_getscheduler(0);
  sched_getparam(0, &before_);
  is_set_ = set_policy(SCHED_FIFO, priority);
  if (!is_set_) report_refusal("dds", priority, errno);
}

PriorityOfDds::~PriorityOfDds() {
  if (is_set_) sched_setscheduler(0, policy_, &before_);
}

}  // namespace tandem::runtime
