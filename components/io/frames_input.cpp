// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/frames_input.hpp"

#include <cmath>
#include <utility>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/time.hpp"

namespace tandem {
namespace {

constexpr double kReport = 1.0;  // [s] between reports of frames with two parents

std::optional<double> seconds_of(const Stamp& stamp) {
  if (stamp.sec() == 0 && stamp.nanosec() == 0) return std::nullopt;
  return rt::to_seconds(stamp);
}

bool is_tilted(const Eigen::Isometry3d& X) {
  return X.linear()(2, 2) < std::cos(FramesInput::kMaxTilt);
}

}  // namespace

FramesInput::FramesInput(rt::Node& node, const Frames& names, const LocalizationParams& params,
                         Changed changed)
    : node_{node},
      names_{names},
      timeout_{params.transform_timeout},
      map_is_odom_{params.map_is_odom},
      changed_{std::move(changed)} {
  tf_ = node.create_subscription(topics::tf, [this](const auto& msg) { receive(msg, tf_, false); });
  tf_static_ = node.create_subscription(
      topics::tf_static, [this](const auto& msg) { receive(msg, tf_static_, true); });
  time_jump_ = node.on_time_jump([this] { tree_.on_time_jump(); });
}

rt::Interface FramesInput::interface() { return {.subscribes = {topics::tf, topics::tf_static}}; }

void FramesInput::receive(const tf2_msgs::msg::TFMessage& msg, const rt::Subscription& from,
                          bool is_static) {
  for (const auto& transform : msg.transforms()) receive(transform, from.sender(), is_static);
  ++received_;
  if (changed_) changed_();
}

void FramesInput::receive(const geometry_msgs::msg::TransformStamped& msg,
                          const FrameSender& sender, bool is_static) {
  const auto X_PC = from_msg(msg.transform());
  if (!X_PC)
    return node_.log().error_every(1.0, "{} of `{}` {}: dropped", is_static ? "/tf_static" : "/tf",
                                   msg.child_frame_id(), fault_of(msg.transform().rotation()));
  const FrameLink link{
      msg.header().frame_id(),         msg.child_frame_id(), *X_PC, sender, node_.now(),
      seconds_of(msg.header().stamp())};
  react(is_static ? tree_.set_static(link) : tree_.set(link), msg.child_frame_id(),
        msg.header().frame_id());
}

// Reported with a delay, because discovery needs a moment to name the publishers.
void FramesInput::react(LinkFate fate, const std::string& child, const std::string& parent) {
  if (fate == LinkFate::kFull)
    node_.log().error_every(10.0, "/tf has more than {} frames: `{}` is ignored",
                            FrameTree::kMaxFrames, child);
  if (fate == LinkFate::kUnnamed || fate == LinkFate::kLoop)
    node_.log().warn_every(10.0, "/tf gives frame `{}` the parent `{}`: dropped", child, parent);
  if (fate != LinkFate::kTwoParents || view_) return;
  view_ = std::make_unique<rt::DomainView>(node_);
  report_ = node_.create_wall_timer(kReport, [this] {
    if (const std::string text = two_parents(); !text.empty())
      node_.log().error_every(5.0, "{}; let one of them stop publishing it", text);
  });
}

bool FramesInput::is_map_or_odom(std::string_view frame) const {
  return frame == bare_frame(names_.map) || frame == bare_frame(names_.odom);
}

bool FramesInput::is_world(std::string_view frame) const {
  return is_map_or_odom(bare_frame(frame)) || tree_.is_above(frame, names_.base);
}

bool FramesInput::is_one(std::string_view a, std::string_view b) const {
  return a == b || (map_is_odom_ && is_map_or_odom(a) && is_map_or_odom(b));
}

bool FramesInput::is_map(std::string_view frame) const {
  return frame.empty() || is_one(bare_frame(names_.map), bare_frame(frame));
}

std::optional<FramePose> FramesInput::find(std::string_view a, std::string_view b,
                                           std::optional<double> stamp) const {
  if (is_one(a, b)) return FramePose{.X_BF = Eigen::Isometry3d::Identity()};
  if (const auto found = tree_.find(a, b, stamp)) return found;
  if (map_is_odom_ && is_map_or_odom(a))
    return tree_.find(a == bare_frame(names_.map) ? names_.odom : names_.map, b, stamp);
  return std::nullopt;
}

bool FramesInput::is_fresh(const FramePose& found) const {
  return found.is_static() || node_.now() - found.arrival <= timeout_;
}

Placing FramesInput::place(std::string_view a, std::string_view b, const Stamp& stamp) const {
  a = bare_frame(a);
  b = bare_frame(b);
  const auto found = find(a, b, seconds_of(stamp));
  if (!found) return {.refusal = tree_.why_not(a, b)};
  if (!is_fresh(*found))
    return {.refusal =
                fmt::format("the pose of `{}` in `{}` on /tf is older than transform_timeout, {} s",
                            b, a, timeout_)};
  if (found->drift > kMaxDrift)
    return {.refusal = fmt::format("`{}` moves in `{}`, and /tf has no transform for that time yet",
                                   b, a)};
  return {.X_AB = found->X_BF, .is_static = found->is_static()};
}

bool FramesInput::moves(std::string_view a, std::string_view b) const {
  return tree_.moved(a, b) > kMaxMotion;
}

Placing FramesInput::in_map(std::string_view frame, const Stamp& stamp) const {
  return place(names_.map, frame.empty() ? names_.map : frame, stamp);
}

std::optional<Pose2> FramesInput::in_map(const std_msgs::msg::Header& header,
                                         const char* topic) const {
  return unless_refused(in_map(header.frame_id(), header.stamp()), header, topic);
}

std::optional<Pose2> FramesInput::in_map_by_tf(const std_msgs::msg::Header& header,
                                               const char* topic) const {
  const auto map = bare_frame(names_.map), frame = bare_frame(header.frame_id());
  const bool by_parameter = frame != map && is_one(map, frame) && !tree_.find(map, frame);
  return unless_refused(
      by_parameter ? Placing{.refusal = tree_.why_not(map, frame)} : in_map(frame, header.stamp()),
      header, topic);
}

std::optional<Pose2> FramesInput::unless_refused(Placing placing,
                                                 const std_msgs::msg::Header& header,
                                                 const char* topic) const {
  if (placing.X_AB && !is_tilted(*placing.X_AB)) return in_plane(*placing.X_AB);
  if (placing.X_AB) placing.refusal = "its plane is not horizontal";
  node_.log().write_every(1.0, rt::LogLevel::kWarn, topic,
                          fmt::format("{} is given in frame `{}`, not `{}`: dropped: {}", topic,
                                      header.frame_id(), names_.map, placing.refusal));
  return std::nullopt;
}

std::string FramesInput::why_not_localised() const {
  const auto map = bare_frame(names_.map), odom = bare_frame(names_.odom);
  return find(map, odom, {}) ? std::string{} : tree_.why_not(map, odom);
}

std::string FramesInput::id_of(const FrameSender& sender) {
  std::string id;
  for (const std::uint8_t byte : sender) id += fmt::format("{:02x}", byte);
  return id;
}

std::string FramesInput::name_of(const FrameSender& sender) const {
  const std::string id = id_of(sender);
  if (!view_) return "publisher " + id;
  for (const auto& endpoint : view_->look().endpoints)
    if (endpoint.id == id && !endpoint.node.empty()) return endpoint.node;
  return "publisher " + id;
}

std::string FramesInput::two_parents() const {
  std::string text;
  for (const auto& [child, two] : tree_.two_parents()) {
    if (node_.now() - two.t > kRecently) continue;
    text += fmt::format("{}frame `{}` has two parents on /tf: `{}` by {}, `{}` by {}",
                        text.empty() ? "" : "; ", child, two.parent, name_of(two.sender), two.other,
                        name_of(two.other_sender));
    if (text.size() > 500) return text + "; …";
  }
  return text;
}

}  // namespace tandem
