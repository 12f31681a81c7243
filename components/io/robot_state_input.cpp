// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/robot_state_input.hpp"

#include <algorithm>

#include "tandem/io/topics.hpp"
#include "tandem/model/reasons.hpp"

namespace tandem {

RobotStateInput::RobotStateInput(rt::Node& node, const RobotStateParams& params,
                                 std::function<void(double)> on_odom)
    : node_{node},
      params_{params},
      localization_{params.localization},
      on_odom_{std::move(on_odom)},
      frames_{node, params.frames, params.localization, [this] { on_frames(); }} {
  odom_ = node.create_subscription(topics::odom, [this](const auto& msg) { this->on_odom(msg); });
}

rt::Interface RobotStateInput::interface() {
  return rt::Interface{.subscribes = {topics::odom}} + FramesInput::interface();
}

void RobotStateInput::on_odom(const nav_msgs::msg::Odometry& msg) {
  auto odometry = from_msg(msg);
  if (!odometry) {
    node_.log().warn_every(1.0, "odom {}: dropped", fault_of(msg.pose().pose().orientation()));
    return;
  }
  odom_refusal_ = place(*odometry, msg);
  if (!odom_refusal_.empty()) {
    node_.log().error_every(5.0, "{}", odom_refusal_);
    return;
  }
  localization_.on_odom(odometry->X, odometry->twist, node_.now(), lateness(msg.header().stamp()));
  tell();
  if (on_odom_) on_odom_(rt::to_seconds(msg.header().stamp()));
}

// Transforms the odometry to the frames odom and base. Returns why that is impossible, or an empty
// string.
std::string RobotStateInput::place(Odometry& odometry, const nav_msgs::msg::Odometry& msg) const {
  const Frames& names = frames_.names();
  const std::string &frame = msg.header().frame_id(), &child = msg.child_frame_id();
  const Placing in_odom = frames_.place(names.odom, frame.empty() ? names.odom : frame);
  if (!in_odom.X_AB)
    return fmt::format("odom is given in frame `{}`, not `{}` (odom_frame): dropped: {}", frame,
                       names.odom, in_odom.refusal);
  const Placing on_robot = frames_.place(child.empty() ? names.base : child, names.base);
  if (!on_robot.X_AB)
    return fmt::format("odom is of frame `{}`, not `{}` (base_frame): dropped: {}", child,
                       names.base, on_robot.refusal);
  if (on_robot.moves)
    return fmt::format("odom is of frame `{}`, which moves against `{}` (base_frame): dropped",
                       child, names.base);
  odometry.twist = twist_of(in_plane(*on_robot.X_AB), msg.twist().twist());
  odometry.X = compose(compose(in_plane(*in_odom.X_AB), odometry.X), in_plane(*on_robot.X_AB));
  return {};
}

// Ignores changes elsewhere in the tree, which do not affect the robot's state.
void RobotStateInput::on_frames() {
  const auto found = frames_.tree().find(frames_.names().map, frames_.names().odom);
  if (!found ||
      (X_MW_ && X_MW_->heard == found->heard && X_MW_->X_BF.matrix() == found->X_BF.matrix()))
    return;
  X_MW_ = found;
  const double now = node_.now();
  if (found->is_static())
    localization_.on_static_transform(in_plane(found->X_BF));
  else
    localization_.on_transform(in_plane(found->X_BF), now, now - found->heard);
  tell();
}

std::string RobotStateInput::frame_trouble() const {
  return odom_refusal_.empty() ? frames_.why_not_localised() : odom_refusal_;
}

std::string RobotStateInput::missing() const {
  const std::string trouble = frame_trouble();
  return std::string{text_of(Reason::kNotLocalized)} + ": " +
         (trouble.empty() ? "odom or map → odom is missing or too old" : trouble);
}

void RobotStateInput::tell() {
  if (!on_state_) return;
  if (const auto heard = state()) on_state_(*heard);
}

double RobotStateInput::lateness(const Stamp& stamp) const {
  if (!usual_age_ || (stamp.sec() == 0 && stamp.nanosec() == 0)) return 0.0;
  const double late = rt::to_seconds(node_.stamp()) - rt::to_seconds(stamp) - *usual_age_;
  if (late > params_.localization.odom_timeout)
    node_.log().warn_every(1.0,
                           "odom comes {:.3f} s late by its stamp: the network is slow, or the "
                           "sender's clock is wrong (odom_stamped: false if it cannot be set)",
                           late);
  return std::max(0.0, late);
}

std::optional<RobotState> RobotStateInput::state() { return localization_.state(node_.now()); }

}  // namespace tandem
