// SPDX-License-Identifier: Apache-2.0
// Keeps the transforms of /tf and /tf_static and computes the pose of one frame in another.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "tandem/model/se2.hpp"

namespace tandem {

/// GUID of a transform's publisher.
using FrameSender = std::array<std::uint8_t, 16>;

/// A frame's name as tf2 compares it: without a leading slash.
[[nodiscard]] inline std::string_view bare_frame(std::string_view name) {
  return name.starts_with('/') ? name.substr(1) : name;
}

/// The part of a pose in space that lies in the plane: x, y and yaw.
[[nodiscard]] inline Pose2 in_plane(const Eigen::Isometry3d& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

/// The planar pose in space, at height 0.
[[nodiscard]] inline Eigen::Isometry3d in_space(const Pose2& X) {
  return Eigen::Translation3d(X.x, X.y, 0.0) * Eigen::AngleAxisd(X.theta, Eigen::Vector3d::UnitZ());
}

/// One transform of a message: `child` lies at X_PC in `parent`.
struct FrameLink {
  std::string_view parent, child;  ///< names, with or without a leading slash
  Eigen::Isometry3d X_PC = Eigen::Isometry3d::Identity();  ///< rotation and translation [m]
  FrameSender sender = {};                                 ///< zeros if unknown
  double arrival = 0.0;                                    ///< arrival time [s]
  std::optional<double> stamp;  ///< timestamp of its header [s]; nullopt if it has none
};

/// Result of adding a link.
enum class LinkFate {
  kTaken,
  kTwoParents,  ///< accepted, but the child had another parent before
  kUnnamed,     ///< refused: a name is empty or longer than kLongest
  kLoop,        ///< refused: a frame is not its own parent
  kFull,        ///< refused: the tree already holds kMaxFrames frames
};

/// Pose of one frame F in another frame B.
struct FramePose {
  static constexpr double kAlways = std::numeric_limits<double>::infinity();  ///< [s]

  Eigen::Isometry3d X_BF;    ///< pose of F in B
  double arrival = kAlways;  ///< arrival of the oldest dynamic link [s]; kAlways: all are static
  double drift = 0.0;        ///< possible motion between the newest link and the stamp [m]

  /// Whether only static links join the two frames.
  [[nodiscard]] bool is_static() const { return arrival == kAlways; }
};

/// A child that was given two parents, with the publisher of each; the newer one is used.
struct TwoParents {
  std::string parent, other;         ///< the parent in use, and the earlier one
  FrameSender sender, other_sender;  ///< the publisher of each
  double t;                          ///< when this was last noticed [s]
};

/// Frames and the links between them, by the rules of tf2: a leading slash is ignored; a frame has
/// one parent, the last one received; two frames are connected if their chains of parents meet;
/// chains of several dynamic links are composed at the newest stamp that all of them have reached.
///
/// Dynamic links take precedence over static ones of the same child. `arrival` and `now` are
/// arrival times on one clock. Stamps only relate links to each other, so a sender's clock may
/// differ from this one's.
class FrameTree {
 public:
  static constexpr std::size_t kMaxFrames = 2'000;  ///< frames; further ones are refused
  static constexpr std::size_t kLongest = 255;      ///< longest name [bytes]
  static constexpr std::size_t kSamples = 64;       ///< samples kept of a dynamic link …
  static constexpr double kSpacing = 0.03;          ///< … at least this far apart [s]
  static constexpr double kMaxApart = 0.5;      ///< [s] lag of a link behind the samples of another
  static constexpr double kMotionWindow = 1.0;  ///< [s] over which moved() looks back
  static constexpr std::size_t kMaxListed = 12;  ///< links listed in a text

  /// Adds a static link, valid forever.
  LinkFate set_static(const FrameLink& link);
  /// Adds a dynamic link, which ages.
  LinkFate set(const FrameLink& link);
  /// As set_static, without a sender.
  void set(const std::string& parent, const std::string& child, const Eigen::Isometry3d& X_PC) {
    set_static({.parent = parent, .child = child, .X_PC = X_PC, .stamp = {}});
  }

  /// Pose of `frame` in `base`; nullopt if they are not connected or one link lags by more than
  /// kMaxApart. At `stamp` [s], or at the newest time that all links have reached. A stamp beyond
  /// the samples uses the nearest sample.
  [[nodiscard]] std::optional<FramePose> find(std::string_view base, std::string_view frame,
                                              std::optional<double> stamp = {}) const;
  /// X_BF of find() at the newest common time.
  [[nodiscard]] std::optional<Eigen::Isometry3d> pose(std::string_view base,
                                                      std::string_view frame) const;

  /// How far `frame` has moved against `base` in the plane within the last kMotionWindow [m]: the
  /// greatest distance between its newest pose and an earlier one, plus the turn as that of a point
  /// 1 m away. Measured in the planes of both frames; the smaller value counts, because roll, pitch
  /// and height of one of them are no motion in the plane of the other. Of a frame that is tilted
  /// by more than 45°, as optical frames are, only the motion in the plane of `base` counts. Zero
  /// if only static links join the frames, or none.
  [[nodiscard]] double moved(std::string_view base, std::string_view frame) const;

  /// Whether `frame` is an ancestor of `base` with a dynamic link between them.
  [[nodiscard]] bool is_above(std::string_view frame, std::string_view base) const;

  /// Why find() returns nullopt, with a list of the known frames.
  [[nodiscard]] std::string why_not(std::string_view base, std::string_view frame) const;
  /// "map → odom, odom → base_link", at most kMaxListed of them; "none" if there are none.
  [[nodiscard]] std::string listing() const;

  /// Children that were given two parents, by name.
  [[nodiscard]] const std::map<std::string, TwoParents>& two_parents() const {
    return two_parents_;
  }

  /// Visits each link in alphabetical order of the children: (child, parent, is_static, sender).
  void for_each(const std::function<void(const std::string&, const std::string&, bool,
                                         const FrameSender&)>& visit) const;

  /// Call after the clock jumped back: the age of dynamic links is unknown, so that they count as
  /// infinitely old.
  void on_time_jump();

 private:
  struct Sample {
    double time;  // as Link::time
    Eigen::Quaterniond q_PC;
    Eigen::Vector3d p_PC;
  };
  struct Link {
    std::string parent;
    Eigen::Isometry3d X_PC = Eigen::Isometry3d::Identity();  // newest value
    FrameSender sender = {};
    double arrival = FramePose::kAlways;
    std::optional<double> stamp = {};  // of the newest value
    double time =
        -FramePose::kAlways;       // of the newest value: its stamp, or its arrival without one
    std::deque<Sample> past = {};  // oldest first

    [[nodiscard]] bool is_dynamic() const { return arrival != FramePose::kAlways; }
    void remember(const FrameLink& link);
    [[nodiscard]] Eigen::Isometry3d at(double t) const;
    [[nodiscard]] double speed() const;
  };
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view name) const {
      return std::hash<std::string_view>{}(name);
    }
  };
  using Chain = std::vector<const Link*>;  // from a frame up to its root
  struct Branches {
    Chain down, up;               // from base and from frame up to their common ancestor
    Chain moving;                 // the dynamic links of both
    std::optional<double> stamp;  // the newest time that all of these have reached
  };

  LinkFate add(const FrameLink& link, bool is_static);
  void note_parents(const std::string& child, const Link& old, const FrameLink& link);
  [[nodiscard]] std::optional<Chain> chain_of(std::string_view frame) const;
  [[nodiscard]] static std::string_view root_of(const Chain& chain, std::string_view frame);
  [[nodiscard]] std::optional<Branches> between(std::string_view base,
                                                std::string_view frame) const;
  [[nodiscard]] static Eigen::Isometry3d composed(const Chain& chain, std::optional<double> t,
                                                  double ago);
  [[nodiscard]] static Eigen::Isometry3d composed(const Branches& branches, double ago);
  [[nodiscard]] static std::optional<double> common_stamp(const Chain& links);
  [[nodiscard]] static double first_stamp(const Chain& links);
  [[nodiscard]] bool contains(std::string_view frame) const;

  std::unordered_map<std::string, Link, Hash, std::equal_to<>> links_;  // by child
  std::map<std::string, TwoParents> two_parents_;                       // by child
};

}  // namespace tandem
