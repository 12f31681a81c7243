// SPDX-License-Identifier: Apache-2.0
// Real-time priorities of threads that Fast DDS starts. Private to runtime/.
#pragma once

#include <future>

namespace tandem::runtime {

/// What use_real_time_for_dds() has set; 0: none.
[[nodiscard]] int priority_of_dds();
/// Gives the calling thread, and those that it starts later, a real-time priority.
void use_real_time_with_children(int priority);

/// Returns what `make` returns. The threads that it starts have priority_of_dds(): it is called on
/// another thread then, because one that has a priority of its own may not pass it on.
template <class Make>
auto made_with_priority_of_dds(const Make& make) {
  const int priority = priority_of_dds();
  if (priority == 0) return make();
  return std::async(std::launch::async,
                    [&] {
                      use_real_time_with_children(priority);
                      return make();
                    })
      .get();
}

}  // namespace tandem::runtime
