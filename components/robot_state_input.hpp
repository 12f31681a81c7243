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

/// Subscribes `odom`, `/tf` and `/tf_static` for a node and composes them. Calls `on_odom` after
/// each odometry, with the message's stamp [s].
class RobotStateInput {
 public:
  RobotStateInput(rt::Node& node, const RobotStateParams& params,
                  std::function<void(double)> on_odom = {});
  /// From now on odometry that is older by its stamp than `usual` [s] counts as of when it was due,
  /// not of when it came: a slow network must not make an old pose new.
  void believe_stamps(double usual) { usual_age_ = usual; }
  /// Calls `heard` after each odometry and each transform, with the state that it made, if any.
  void on_state(std::function<void(const RobotState&)> heard) { on_state_ = std::move(heard); }
  RobotStateInput(const RobotStateInput&) = delete;
  RobotStateInput& operator=(const RobotStateInput&) = delete;

  /// Nothing while odometry or transform is missing or too old.
  [[nodiscard]] std::optional<RobotState> state();

  /// X_WB of the newest odometry, as Localization has it.
  [[nodiscard]] const Pose2& odometry() const { return localization_.odometry(); }

 private:
  [[nodiscard]] double lateness(const Stamp& stamp) const;
  void tell();

  rt::Node& node_;
  RobotStateParams params_;
  std::optional<double> usual_age_;  ///< of odometry when it comes [s]
  Localization localization_;
  std::function<void(double)> on_odom_;
  std::function<void(const RobotState&)> on_state_;
  rt::Subscription odom_, tf_, tf_static_;
};

}  // namespace tandem
