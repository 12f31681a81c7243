// SPDX-License-Identifier: Apache-2.0
// Subscribes to odom and tf, and composes the robot's state in the map frame.
#pragma once

#include <functional>
#include <optional>

#include "tandem/io/conversions.hpp"
#include "tandem/io/frames_input.hpp"
#include "tandem/model/localization.hpp"
#include "tandem/runtime/node.hpp"

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
///
/// Odometry of another frame than `odom_frame`, or of another one on the robot than `base_frame`,
/// is transformed where `/tf` knows the frame, else dropped. An empty name counts as the right one.
class RobotStateInput {
 public:
  RobotStateInput(rt::Node& node, const RobotStateParams& params,
                  std::function<void(double)> on_odom = {});
  /// From now on odometry whose stamp is older than `usual` [s] is dated by when it was due, not by
  /// its arrival, so that a slow network does not make an old pose look new.
  void believe_stamps(double usual) { usual_age_ = usual; }
  /// Calls `heard` after each odometry and each transform, with the state that it made, if any.
  void on_state(std::function<void(const RobotState&)> heard) { on_state_ = std::move(heard); }
  RobotStateInput(const RobotStateInput&) = delete;
  RobotStateInput& operator=(const RobotStateInput&) = delete;

  /// Nothing while odometry or transform is missing or too old.
  [[nodiscard]] std::optional<RobotState> state();

  /// X_WB of the newest odometry, as Localization has it.
  [[nodiscard]] const Pose2& odometry() const { return localization_.odometry(); }
  /// The frames that the node knows, for its other inputs.
  [[nodiscard]] const FramesInput& frames() const { return frames_; }
  /// What is wrong with the frames of odometry or map → odom, with those that are there; empty if
  /// nothing is: then it is for silence that there is no state.
  [[nodiscard]] std::string frame_trouble() const;
  /// Why there is no state: "not localized: …".
  [[nodiscard]] std::string missing() const;

 private:
  void on_odom(const nav_msgs::msg::Odometry& msg);
  void on_frames();
  [[nodiscard]] std::string place(Odometry& odometry, const nav_msgs::msg::Odometry& msg) const;
  [[nodiscard]] double lateness(const Stamp& stamp) const;
  void tell();

  rt::Node& node_;
  RobotStateParams params_;
  std::optional<double> usual_age_;  ///< of odometry when it comes [s]
  Localization localization_;
  std::string odom_refusal_;       ///< of the last odometry's frames
  std::optional<FramePose> X_MW_;  ///< as it was told last
  std::function<void(double)> on_odom_;
  std::function<void(const RobotState&)> on_state_;
  FramesInput frames_;
  rt::Subscription odom_;
};

}  // namespace tandem
