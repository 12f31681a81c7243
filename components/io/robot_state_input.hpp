// SPDX-License-Identifier: Apache-2.0
// Subscribes to odom and tf, and composes the robot's state in the map frame.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "tandem/io/conversions.hpp"
#include "tandem/io/frames_input.hpp"
#include "tandem/model/localization.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Names of the frames, and ages beyond which the state counts as unknown.
struct RobotStateParams {
  LocalizationParams localization;  ///< time-outs
  Frames frames;                    ///< names of the frames

  template <class Visitor>
  void visit(Visitor&& field) {
    localization.visit(field);
    frames.visit(field);
  }
};

/// Subscribes to `odom`, `/tf` and `/tf_static` and composes them. Calls `on_odom` after each
/// odometry message, with its timestamp [s].
///
/// Odometry in a frame other than `odom_frame`, or for a robot frame other than `base_frame`, is
/// transformed if `/tf` has the frame and dropped otherwise. An empty name means the expected
/// frame.
class RobotStateInput {
 public:
  /// `node` must outlive this. All callbacks run on the node's thread.
  RobotStateInput(rt::Node& node, const RobotStateParams& params,
                  std::function<void(double)> on_odom = {});
  /// The topics that it opens.
  [[nodiscard]] static rt::Interface interface();
  /// From now on, odometry whose timestamp is older than `usual` [s] on arrival is dated back by
  /// the excess, so that a slow network does not make an old pose look new.
  void use_stamps(double usual) { usual_age_ = usual; }
  /// Calls `fn` with the state, if there is one, after each odometry message and each new
  /// map → odom transform.
  void on_state(std::function<void(const RobotState&)> fn) { on_state_ = std::move(fn); }
  /// As Subscription::may_wait(), for a node that something else wakes when it needs the state.
  void may_wait(double seconds);
  RobotStateInput(const RobotStateInput&) = delete;
  RobotStateInput& operator=(const RobotStateInput&) = delete;

  /// The newest state; nullopt while odometry or map → odom is missing or too old.
  [[nodiscard]] std::optional<RobotState> state() const;

  /// X_WB of the newest odometry, from Localization.
  [[nodiscard]] const Pose2& odometry() const { return localization_.odometry(); }
  /// The node's frame tree, for its other inputs.
  [[nodiscard]] const FramesInput& frames() const { return frames_; }
  /// The fault in the frames of odometry or map → odom, with the frames that exist. If this is
  /// empty and there is no state, a message is missing or too old.
  [[nodiscard]] std::string frame_trouble() const;
  /// Why there is no state, as "not localized: …".
  [[nodiscard]] std::string missing() const;

 private:
  void on_odom(const nav_msgs::msg::Odometry& msg);
  void on_frames();
  [[nodiscard]] std::optional<Odometry> placed(const nav_msgs::msg::Odometry& msg);
  [[nodiscard]] double lateness(const Stamp& stamp) const;
  void tell();

  rt::Node& node_;
  RobotStateParams params_;
  std::optional<double> usual_age_;  ///< age of odometry on arrival [s]; see use_stamps()
  Localization localization_;
  std::string odom_refusal_;       ///< why the last odometry was dropped; empty if it was not
  std::optional<FramePose> X_MW_;  ///< last transform passed to localization_
  std::function<void(double)> on_odom_;
  std::function<void(const RobotState&)> on_state_;
  FramesInput frames_;
  rt::Subscription odom_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
