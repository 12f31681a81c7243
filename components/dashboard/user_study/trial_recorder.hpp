// SPDX-License-Identifier: Apache-2.0
// In: the topics of the dashboard's robot. Out: a trial, fed with them.
#pragma once

#include <memory>
#include <string>

#include "tandem/dashboard/user_study/trial.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Listens for as long as it lives. Where the robot is, is what the ground truth says if somebody
/// publishes one, else its odometry and its localiser.
class TrialRecorder {
 public:
  TrialRecorder(rt::Node& node, const RobotStateParams& input, const TrialRequest& request);
  TrialRecorder(const TrialRecorder&) = delete;
  TrialRecorder& operator=(const TrialRecorder&) = delete;

  [[nodiscard]] const Trial& trial() const { return trial_; }

 private:
  Trial trial_;
  rt::Subscription truth_;
  std::unique_ptr<RobotStateInput> robot_;  ///< without a ground truth
  rt::Subscription collision_, filter_;
};

}  // namespace tandem
