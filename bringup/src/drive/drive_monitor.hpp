// SPDX-License-Identifier: Apache-2.0
// Measures a running drive from the topics of its nodes.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "bringup/drive/drive_observer.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Receives the state of a running drive every 0.2 s.
using OnProgress = std::function<void(const Progress&)>;

/// Passes the messages of a drive to a DriveObserver, and stops its node when the drive is over or
/// has failed. Publishes nothing. The same on DDS and on a LocalBus.
class DriveMonitor {
 public:
  DriveMonitor(rt::Node& node, DriveObserver drive, OnProgress on_progress);

  /// The drive's log. Throws std::runtime_error that begins with the scenario's name if the drive
  /// failed.
  [[nodiscard]] DriveLog finish(const std::string& scenario) const;

 private:
  void listen_to_robot();
  void listen_to_person();
  void listen_to_components();
  void supervise();
  void fail(const char* why);

  rt::Node& node_;
  DriveObserver drive_;
  OnProgress on_progress_;
  double started_, heard_;  // [s] steady time: the start, and the last ground truth
  std::string trouble_;

  rt::Subscription truth_, collision_, user_, leader_, end_, planner_, filter_, obstacles_;
  std::optional<rt::Subscription> user_stamped_;
  std::shared_ptr<void> stamped_publishers_;
  rt::Timer supervisor_;
};

}  // namespace tandem
