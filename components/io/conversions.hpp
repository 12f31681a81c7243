// SPDX-License-Identifier: Apache-2.0
// Converts between messages and model types, and rejects values that are not finite.
#pragma once

#include <Eigen/Geometry>
#include <msgs.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/map/occupancy_plane.hpp"
#include "tandem/map/range_returns.hpp"
#include "tandem/map/virtual_fixtures.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// A message's timestamp.
using Stamp = builtin_interfaces::msg::Time;

/// Frame names on the wire, shared by all components of a robot.
struct Frames {
  std::string map = "map", odom = "odom", base = "base_link";

  template <class Visitor>
  void visit(Visitor&& field) {
    field("map_frame", map, "frame in which obstacles are given");
    field("odom_frame", odom, "frame in which odometry is given");
    field("base_frame", base, "frame of the robot's body");
  }
};

/// Odometry or ground truth: pose of the child frame in the header's frame, body twist.
struct Odometry {
  Pose2 X;       ///< of B
  Twist2 twist;  ///< of B
};

/// A header with this timestamp and frame.
[[nodiscard]] std_msgs::msg::Header header(const Stamp& stamp, const std::string& frame);

/// Forward speed and yaw rate (axes as in REP-103); the other four components are ignored. nullopt
/// if one of the two is not finite.
[[nodiscard]] std::optional<Twist2> from_msg(const geometry_msgs::msg::Twist& msg);
/// Forward speed and yaw rate; the other four components are zero.
[[nodiscard]] geometry_msgs::msg::Twist to_msg(const Twist2& twist);

/// Why from_msg rejects a pose: "is not finite", or that its quaternion is zero.
[[nodiscard]] const char* fault_of(const geometry_msgs::msg::Quaternion& orientation);

/// The planar pose, heading from the quaternion's yaw. nullopt if a number is not finite or the
/// quaternion is zero.
[[nodiscard]] std::optional<Pose2> from_msg(const geometry_msgs::msg::Pose& msg);
/// The pose at height 0.
[[nodiscard]] geometry_msgs::msg::Pose to_msg(const Pose2& X);
/// The pose at height 0, with a header.
[[nodiscard]] geometry_msgs::msg::PoseStamped to_msg(const Pose2& X,
                                                     const std_msgs::msg::Header& header);

/// Pose and twist as the message has them, in its frames. nullopt if a number is not finite or the
/// quaternion is zero.
[[nodiscard]] std::optional<Odometry> from_msg(const nav_msgs::msg::Odometry& msg);
/// Odometry of frame B in frame A. `of_C` is of the child frame C in the header's frame F, and B is
/// fixed to the same body as C. The frames may be tilted: poses and twist are transformed in space,
/// and the result is their part in the plane of A, with B's lateral velocity left out. nullopt as
/// above; other numbers that are not finite count as 0.
[[nodiscard]] std::optional<Odometry> from_msg(const nav_msgs::msg::Odometry& of_C,
                                               const Eigen::Isometry3d& X_AF,
                                               const Eigen::Isometry3d& X_CB);
/// Ground truth. It is not transformed: nullopt if its frame is neither `map` nor empty.
[[nodiscard]] std::optional<Odometry> truth_from(const nav_msgs::msg::Odometry& msg,
                                                 const std::string& map);
/// `odometry` of the frame `child` in the header's frame.
[[nodiscard]] nav_msgs::msg::Odometry to_msg(const Odometry& odometry,
                                             const std_msgs::msg::Header& header,
                                             const std::string& child);

/// The transform parent → child in the message; nullopt if it is missing or not finite.
[[nodiscard]] std::optional<Pose2> find_transform(const tf2_msgs::msg::TFMessage& msg,
                                                  const std::string& parent,
                                                  const std::string& child);
/// The planar transform from the header's frame to `child`, at height 0.
[[nodiscard]] geometry_msgs::msg::TransformStamped to_transform(const Pose2& X,
                                                                const std_msgs::msg::Header& header,
                                                                const std::string& child);

/// The 3D transform. nullopt if a number is not finite or the quaternion is zero.
[[nodiscard]] std::optional<Eigen::Isometry3d> from_msg(const geometry_msgs::msg::Transform& msg);
/// The transform from the header's frame to `child`.
[[nodiscard]] geometry_msgs::msg::TransformStamped to_transform(const Eigen::Isometry3d& X,
                                                                const std_msgs::msg::Header& header,
                                                                const std::string& child);

/// Obstacles that are finite with a ≥ b > 0 and a known shape; others are counted in `refused`.
struct Obstacles {
  std::vector<Obstacle> all;  ///< the valid ones
  int refused = 0;            ///< number of those left out
};
/// Why obstacles are left out, for a log line.
inline constexpr const char* kNotValid =
    "not finite, or without semi_axis_a >= semi_axis_b > 0, or of an unknown shape";

/// The obstacles of the message, in its frame; those that are not valid are counted and left out.
[[nodiscard]] Obstacles from_msg(const tandem_msgs::msg::ObstacleArray& msg);
/// The obstacles, in the header's frame.
[[nodiscard]] tandem_msgs::msg::ObstacleArray to_msg(std::span<const Obstacle> obstacles,
                                                     const std_msgs::msg::Header& header);

/// The scan as a view into the message, which must outlive it. Intensities are not read.
[[nodiscard]] RangeScan from_msg(const sensor_msgs::msg::LaserScan& msg);
/// The range returns of a sensor; a malformed message sets their error.
[[nodiscard]] RangeReturns from_msg(const sensor_msgs::msg::PointCloud2& msg);

/// The poses as a path in the header's frame.
[[nodiscard]] nav_msgs::msg::Path to_path(std::span<const Pose2> X,
                                          const std_msgs::msg::Header& header);
/// The message's plane, unchecked; error_of() reports faults. An origin with a zero quaternion
/// becomes one that is not finite.
[[nodiscard]] OccupancyPlane from_msg(const nav_msgs::msg::OccupancyGrid& msg);
/// 100 occupied, 0 free, −1 unknown, as RViz and Nav2 read it.
[[nodiscard]] nav_msgs::msg::OccupancyGrid to_msg(const Grid& grid,
                                                  const std_msgs::msg::Header& header);

/// Flat cylinders, `namespace` "obstacles", preceded by a marker that deletes the old ones.
[[nodiscard]] visualization_msgs::msg::MarkerArray to_markers(std::span<const Obstacle> obstacles,
                                                              const std_msgs::msg::Header& header);
/// Outlines of forbidden regions and guidance lines, in separate marker namespaces.
[[nodiscard]] std::vector<visualization_msgs::msg::Marker> to_markers(
    const VirtualFixtures& fixtures, const std_msgs::msg::Header& header);
/// An arrow for the leader and a line for its leash.
[[nodiscard]] visualization_msgs::msg::MarkerArray leader_markers(
    const Pose2& X_ML, const Pose2& X_MB, const std_msgs::msg::Header& header);
/// An arrow at each goal with its likelihood as opacity, and the likelihood in percent as text.
[[nodiscard]] visualization_msgs::msg::MarkerArray goal_markers(
    std::span<const Pose2> X_MG, std::span<const double> belief,
    const std_msgs::msg::Header& header);

}  // namespace tandem
