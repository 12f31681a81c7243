// SPDX-License-Identifier: Apache-2.0
// Feeds a trial with the topics of the dashboard's robot.
#pragma once

#include <memory>
#include <string>

#include "tandem/dashboard/user_study/trial.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Subscribes for its lifetime. The pose is the ground truth if it is published, otherwise odometry
/// and localization.
class TrialRecorder {
 public:
  TrialRecorder(rt::Node& node, const RobotStateParams& input, const TrialRequest& request);
  TrialRecorder(const TrialRecorder&) = delete;
  TrialRecorder& operator=(const TrialRecorder&) = delete;

  [[nodiscard]] const Trial& trial() const { return trial_; }

 private:
  Trial trial_;
  rt::Subscription truth_;
  std::unique_ptr<RobotStateInput> robot_;  ///< if there is no ground truth
  rt::Subscription collision_, filter_;
};

}  // namespace tandem
