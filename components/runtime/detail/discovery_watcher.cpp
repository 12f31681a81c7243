// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/discovery_watcher.hpp"

#include <utility>

namespace tandem::runtime {

void DiscoveryWatcher::watch(std::set<std::string> topics) {
  const std::lock_guard lock{mutex_};
  watched_ = std::move(topics);
}

void DiscoveryWatcher::note_change(const std::string& topic) {
  {
    const std::lock_guard lock{mutex_};
    if (!watched_.contains(topic)) return;
    changed_.insert(topic);
    if (has_changes_.exchange(true)) return;
  }
  wake_up_->notify();
}

std::set<std::string> DiscoveryWatcher::take() {
  const std::lock_guard lock{mutex_};
  has_changes_ = false;
  return std::exchange(changed_, {});
}

}  // namespace tandem::runtime
