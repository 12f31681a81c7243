// SPDX-License-Identifier: Apache-2.0
// Subscribes to /tf and /tf_static, and looks up the frames of other messages.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "tandem/io/conversions.hpp"
#include "tandem/model/frame_tree.hpp"
#include "tandem/model/localization.hpp"
#include "tandem/runtime/domain_view.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// The result of a transform lookup: the transform, or why there is none.
struct Placing {
  std::optional<Eigen::Isometry3d> X_AB = {};  ///< nullopt: refused
  bool is_static = true;                       ///< X_AB does not change
  std::string refusal = {};                    ///< why there is no X_AB; empty if there is
};

/// The frame tree shared by all inputs of a node, so that they accept the same frames and reject
/// unknown ones with the same reason.
///
/// A frame is as old as the oldest dynamic link of its chain, and too old after
/// `transform_timeout`. With `map_is_odom` map and odom are one frame. A child with two parents is
/// logged with both publishers.
class FramesInput {
 public:
  /// A callback on the node's thread.
  using Changed = std::function<void()>;
  static constexpr double kMaxTilt = 0.1;     ///< maximum tilt of a planar frame [rad]
  static constexpr double kMaxMotion = 0.05;  ///< [m] of a frame at rest in FrameTree::moved()
  static constexpr double kMaxDrift = 0.1;    ///< maximum motion from link to timestamp [m]

  /// `changed` is called after each message of either topic.
  FramesInput(rt::Node& node, const Frames& names, const LocalizationParams& params,
              Changed changed = {});
  /// The topics that it opens.
  [[nodiscard]] static rt::Interface interface();
  /// As Subscription::may_wait(), for `/tf`.
  void may_wait(double seconds) { tf_.may_wait(seconds); }
  FramesInput(const FramesInput&) = delete;
  FramesInput& operator=(const FramesInput&) = delete;

  /// The names of map, odom and base frame.
  [[nodiscard]] const Frames& names() const { return names_; }
  /// All frames received so far.
  [[nodiscard]] const FrameTree& tree() const { return tree_; }
  /// Number of messages so far. While it is unchanged, lookups change only as frames become too
  /// old.
  [[nodiscard]] std::uint64_t received() const { return received_; }

  /// X_AB of frame B in frame A at `stamp`, or the newest one if `stamp` is zero.
  [[nodiscard]] Placing place(std::string_view a, std::string_view b,
                              const Stamp& stamp = {}) const;
  /// Whether frame B moves in frame A in the plane, by more than kMaxMotion within a second.
  [[nodiscard]] bool moves(std::string_view a, std::string_view b) const;
  /// X_MF of a message's frame F in the map. An empty name means the map frame.
  [[nodiscard]] Placing in_map(std::string_view frame, const Stamp& stamp = {}) const;
  /// The same in the plane, for a message of `topic`. Logs the reason if there is no result.
  [[nodiscard]] std::optional<Pose2> in_map(const std_msgs::msg::Header& header,
                                            const char* topic) const;
  /// The same for poses set by a person in a tool such as RViz: uses `/tf` only, because the tool
  /// does not know `map_is_odom` and treats map and odom as two frames.
  [[nodiscard]] std::optional<Pose2> in_map_by_tf(const std_msgs::msg::Header& header,
                                                  const char* topic) const;
  /// Whether `frame` is the map frame, or odom with `map_is_odom`. An empty name means the map
  /// frame.
  [[nodiscard]] bool is_map(std::string_view frame) const;
  /// Whether the robot moves in that frame: map, odom, or another ancestor of base on /tf.
  [[nodiscard]] bool is_world(std::string_view frame) const;
  /// Why map → odom is unknown, with the frames that exist; empty if it is known.
  [[nodiscard]] std::string why_not_localised() const;

  /// The sender's GUID in hexadecimal, in the form of rt::DomainEndpoint::id.
  [[nodiscard]] static std::string id_of(const FrameSender& sender);
  /// The publisher as "/ns/name"; its GUID until discovery assigns it to a node.
  [[nodiscard]] std::string name_of(const FrameSender& sender) const;
  /// Describes each child with two parents in the last kRecently [s]; may be empty.
  [[nodiscard]] std::string two_parents() const;

 private:
  void receive(const tf2_msgs::msg::TFMessage& msg, const rt::Subscription& from, bool is_static);
  void receive(const geometry_msgs::msg::TransformStamped& msg, const FrameSender& sender,
               bool is_static);
  [[nodiscard]] std::optional<Pose2> unless_refused(Placing placing,
                                                    const std_msgs::msg::Header& header,
                                                    const char* topic) const;
  void react(LinkFate fate, const std::string& child, const std::string& parent);
  [[nodiscard]] bool is_one(std::string_view a, std::string_view b) const;
  [[nodiscard]] bool is_map_or_odom(std::string_view frame) const;
  [[nodiscard]] bool is_fresh(const FramePose& found) const;
  [[nodiscard]] std::optional<FramePose> find(std::string_view a, std::string_view b,
                                              std::optional<double> stamp) const;

  static constexpr double kRecently = 10.0;  // [s]

  rt::Node& node_;
  Frames names_;
  double timeout_;  // [s]
  bool map_is_odom_;
  Changed changed_;
  FrameTree tree_;
  std::uint64_t received_ = 0;
  std::unique_ptr<rt::DomainView> view_;  // created when publishers must be named
  rt::Timer report_;                      // created with view_
  rt::Subscription tf_, tf_static_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
