// SPDX-License-Identifier: Apache-2.0
// In: people. Out: who walks where, for every node that must know.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "tandem/io/frames_input.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Subscribes `people` for a node. A list in another frame is transformed where `/tf` knows that
/// frame. One of an unknown frame or of none, or with somebody in it who is no finite
/// ellipse, is logged and dropped whole: who is left out of it might be the one in the way. So is
/// each while two nodes publish them, and for `kTwoSpeak` after: a list tells of everybody near,
/// and one of the two leaves out whom the other sees.
class ObstacleTracksInput {
 public:
  using Stamped = std::function<void(std::vector<Obstacle>)>;
  static constexpr double kTwoSpeak = 1.0;  // [s]

  ObstacleTracksInput(rt::Node& node, const FramesInput& frames, Stamped heard);
  ObstacleTracksInput(const ObstacleTracksInput&) = delete;
  ObstacleTracksInput& operator=(const ObstacleTracksInput&) = delete;

 private:
  void take(const tandem_msgs::msg::ObstacleArray& msg);
  [[nodiscard]] bool two_speak();

  rt::Node& node_;
  const FramesInput& frames_;
  Stamped heard_;
  std::optional<rt::PublisherId> sender_ = {};  // of the last list
  double sent_ = 0.0, two_until_ = 0.0;  // [s] steady: when that was; how long two count as it
  rt::Subscription people_;
};

}  // namespace tandem
