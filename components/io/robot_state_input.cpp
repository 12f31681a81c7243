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
  time_jump_ = node.on_time_jump([this] { localization_.on_time_jump(); });
}

void RobotStateInput::may_wait(double seconds) {
  odom_.may_wait(seconds);
  frames_.may_wait(seconds);
}

rt::Interface RobotStateInput::interface() {
  return rt::Interface{.subscribes = {topics::odom}} + FramesInput::interface();
}

void RobotStateInput::on_odom(const nav_msgs::msg::Odometry& msg) {
  if (!from_msg(msg)) {
    node_.log().warn_every(1.0, "odom {}: dropped", fault_of(msg.pose().pose().orientation()));
    return;
  }
  const auto odometry = placed(msg);
  if (!odometry) {
    node_.log().error_every(5.0, "{}", odom_refusal_);
    return;
  }
  localization_.on_odom(odometry->X, odometry->twist, node_.now(), lateness(msg.header().stamp()));
  tell();
  if (on_odom_) on_odom_(rt::to_seconds(msg.header().stamp()));
}

// The odometry in the frames odom and base; nullopt, with odom_refusal_, if that is impossible.
std::optional<Odometry> RobotStateInput::placed(const nav_msgs::msg::Odometry& msg) {
  const Frames& names = frames_.names();
  const std::string& frame = msg.header().frame_id();
  const std::string& part = msg.child_frame_id().empty() ? names.base : msg.child_frame_id();
  const Placing in_odom = frames_.place(names.odom, frame.empty() ? names.odom : frame);
  const Placing on_part = frames_.place(part, names.base);
  odom_refusal_.clear();
  if (!in_odom.X_AB)
    odom_refusal_ = fmt::format("odom is given in frame `{}`, not `{}` (odom_frame): dropped: {}",
                                frame, names.odom, in_odom.refusal);
  else if (!on_part.X_AB)
    odom_refusal_ = fmt::format("odom is for frame `{}`, not `{}` (base_frame): dropped: {}", part,
                                names.base, on_part.refusal);
  else if (frames_.moves(names.base, part))
    odom_refusal_ = fmt::format(
        "odom is for frame `{}`, which moves relative to `{}` (base_frame): dropped; publish it "
        "for "
        "a frame that is fixed to the robot",
        part, names.base);
  else
    return from_msg(msg, *in_odom.X_AB, *on_part.X_AB);
  return std::nullopt;
}

// Ignores changes elsewhere in the tree, which do not affect the robot's state.
void RobotStateInput::on_frames() {
  const auto found = frames_.tree().find(frames_.names().map, frames_.names().odom);
  if (!found ||
      (X_MW_ && X_MW_->arrival == found->arrival && X_MW_->X_BF.matrix() == found->X_BF.matrix()))
    return;
  X_MW_ = found;
  const double now = node_.now();
  if (found->is_static())
    localization_.on_static_transform(in_plane(found->X_BF));
  else
    localization_.on_transform(in_plane(found->X_BF), now, now - found->arrival);
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
  if (const auto current = state()) on_state_(*current);
}

double RobotStateInput::lateness(const Stamp& stamp) const {
  if (!usual_age_ || (stamp.sec() == 0 && stamp.nanosec() == 0)) return 0.0;
  const double late = rt::to_seconds(node_.stamp()) - rt::to_seconds(stamp) - *usual_age_;
  if (late > params_.localization.odom_timeout)
    node_.log().warn_every(1.0,
                           "odom arrives {:.3f} s late by its stamp: the network is slow, or the "
                           "publisher's clock is wrong (odom_stamped: false if it cannot be set)",
                           late);
  return std::max(0.0, late);
}

std::optional<RobotState> RobotStateInput::state() const {
  return localization_.state(node_.now());
}

}  // namespace tandem
