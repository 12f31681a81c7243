// SPDX-License-Identifier: Apache-2.0
// Tells a node's thread which topics have changed. Private to runtime/.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "tandem/runtime/detail/wake_up.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Collects the topics of one node on which endpoints have come, changed or left, by their DDS
/// names. Changes on other topics neither wake the node nor cost it time: in a fleet, each program
/// that comes or leaves is announced to every robot. Thread-safe.
class TANDEM_EXPORT_FOR_TESTS DiscoveryWatcher {
 public:
  /// `wake_up` is notified when there are changes, once until they are taken.
  explicit DiscoveryWatcher(std::shared_ptr<WakeUp> wake_up) : wake_up_{std::move(wake_up)} {}

  /// From now on notes changes on these topics only. At first there are none.
  void watch(std::set<std::string> topics);
  /// Discovery calls this at each change.
  void note_change(const std::string& topic);
  [[nodiscard]] bool has_changes() const { return has_changes_; }
  /// The watched topics with changes since the last call. A later change is another one.
  [[nodiscard]] std::set<std::string> take();

 private:
  std::shared_ptr<WakeUp> wake_up_;
  std::mutex mutex_;  // guards the sets
  std::set<std::string> watched_, changed_;
  std::atomic<bool> has_changes_ = false;
};

}  // namespace tandem::runtime
