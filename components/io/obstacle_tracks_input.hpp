// SPDX-License-Identifier: Apache-2.0
// Subscribes to people and delivers the obstacle tracks in the map frame.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "tandem/io/frames_input.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Subscribes to `people`. Lists in another frame are transformed by `/tf`. A list with an unknown
/// or empty frame or any invalid ellipse is logged and rejected whole, because dropping one person
/// could drop the one in the robot's path. Lists are also rejected while two nodes publish them,
/// and for `kHoldOff` after, because each list must contain everybody nearby.
class ObstacleTracksInput {
 public:
  /// Takes a list in M, on the node's thread.
  using Receive = std::function<void(std::vector<Obstacle>)>;
  static constexpr double kHoldOff = 1.0;  ///< [s]

  /// `node` and `frames` must outlive this.
  ObstacleTracksInput(rt::Node& node, const FramesInput& frames, Receive receive);
  /// The topic that it opens.
  [[nodiscard]] static rt::Interface interface();
  ObstacleTracksInput(const ObstacleTracksInput&) = delete;
  ObstacleTracksInput& operator=(const ObstacleTracksInput&) = delete;

 private:
  void take(const tandem_msgs::msg::ObstacleArray& msg);
  [[nodiscard]] bool has_two_publishers();

  rt::Node& node_;
  const FramesInput& frames_;
  Receive receive_;
  std::optional<rt::PublisherId> sender_ = {};  // of the last list
  // Arrival of the last list, and until when two publishers are assumed [s], steady clock.
  double sent_ = 0.0, two_until_ = 0.0;
  rt::Subscription people_;
};

}  // namespace tandem
