// SPDX-License-Identifier: Apache-2.0
// In: odom and tf. Out: where the robot is, for every node that must know.
#pragma once

#include <functional>
#include <optional>

#include "convert.hpp"
#include "model/localization.hpp"
#include "runtime/node.hpp"

namespace tandem {

struct RobotStateParams {
  LocalizationParams localization;
  Frames frames;

  template <class Visitor>
  void visit(Visitor&& field) {
    localization.visit(field);
    frames.visit(field);
  }
};

/// Subscribes `odom` and `/tf` for a node and composes them. Calls `on_odom` after each odometry,
/// with the message's stamp [s].
class RobotStateInput {
 public:
  RobotStateInput(rt::Node& node, const RobotStateParams& params,
                  std::function<void(double)> on_odom = {});
  RobotStateInput(const RobotStateInput&) = delete;
  RobotStateInput& operator=(const RobotStateInput&) = delete;

  /// Nothing while odometry or transform is missing or too old.
  [[nodiscard]] std::optional<RobotState> state();

 private:
  rt::Node& node_;
  RobotStateParams params_;
  Localization localization_;
  std::function<void(double)> on_odom_;
  rt::Subscription odom_, tf_;
};

}  // namespace tandem
