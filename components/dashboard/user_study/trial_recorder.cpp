// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/user_study/trial_recorder.hpp"

#include <algorithm>

#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

bool is_published(const rt::Node& node, const char* name) {
  const std::string& self = node.fully_qualified_name();
  const std::string topic = self.substr(0, self.rfind('/') + 1) + name;
  const auto all = node.topics();
  return std::any_of(all.begin(), all.end(), [&](const auto& known) {
    return known.name == topic && !known.publishers.empty();
  });
}

}  // namespace

TrialRecorder::TrialRecorder(rt::Node& node, const RobotStateParams& input,
                             const TrialRequest& request)
    : trial_{request} {
  if (is_published(node, topics::ground_truth.name))
    truth_ = node.create_subscription(topics::ground_truth, [this, input](const auto& msg) {
      if (const auto truth = truth_from(msg, input.frames.map))
        trial_.on_robot(truth->X, rt::to_seconds(msg.header().stamp()));
    });
  else
    robot_ = std::make_unique<RobotStateInput>(node, input, [this](double t) {
      if (const auto state = robot_->state()) trial_.on_robot(state->X_MB, t);
    });
  collision_ = node.create_subscription(
      topics::collision, [this](const auto& msg) { trial_.on_collisions(msg.count()); });
  filter_ = node.create_subscription(
      topics::filter_status, [this](const auto& msg) { trial_.on_clearance(msg.clearance()); });
}

}  // namespace tandem
