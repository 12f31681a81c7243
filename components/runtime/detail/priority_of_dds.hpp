// SPDX-License-Identifier: Apache-2.0
// Gives real-time priorities to threads that a library starts. Private to runtime/.
#pragma once

#include <sched.h>

namespace tandem::runtime {

/// While it exists, threads that the calling thread starts have the priority that was set by
/// use_real_time_for_dds().
class PriorityOfDds {
 public:
  PriorityOfDds();
  ~PriorityOfDds();
  PriorityOfDds(const PriorityOfDds&) = delete;
  PriorityOfDds& operator=(const PriorityOfDds&) = delete;

 private:
  bool is_set_ = false;
  int policy_ = SCHED_OTHER;  // of the calling thread before
  sched_param before_{};
};

}  // namespace tandem::runtime
