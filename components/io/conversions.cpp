// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/conversions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "tandem/model/frame_tree.hpp"

namespace tandem {
namespace {

constexpr double kLeastNorm = 1e-6;  // a shorter quaternion defines no rotation

geometry_msgs::msg::Point point(double x, double y, double z = 0.0) {
  geometry_msgs::msg::Point p;
  p.x(x);
  p.y(y);
  p.z(z);
  return p;
}

geometry_msgs::msg::Quaternion quaternion(double yaw) {
  geometry_msgs::msg::Quaternion q;
  q.z(std::sin(0.5 * yaw));
  q.w(std::cos(0.5 * yaw));
  return q;
}

std::optional<double> yaw(const geometry_msgs::msg::Quaternion& q) {
  const double sine = 2.0 * (q.w() * q.z() + q.x() * q.y());
  const double cosine = q.w() * q.w() + q.x() * q.x() - q.y() * q.y() - q.z() * q.z();
  if (!std::isfinite(sine) || !std::isfinite(cosine)) return std::nullopt;
  if (sine == 0.0 && cosine == 0.0) return std::nullopt;
  return std::atan2(sine, cosine);
}

std::optional<Pose2> finite_pose(double x, double y, const geometry_msgs::msg::Quaternion& q) {
  const auto theta = yaw(q);
  if (!theta) return std::nullopt;
  const Pose2 X{x, y, *theta};
  return is_finite(X) ? std::optional{X} : std::nullopt;
}

std_msgs::msg::ColorRGBA color(float r, float g, float b, float a) {
  std_msgs::msg::ColorRGBA c;
  c.r(r);
  c.g(g);
  c.b(b);
  c.a(a);
  return c;
}

visualization_msgs::msg::Marker marker(const std_msgs::msg::Header& header, const char* ns,
                                       std::int32_t id, std::int32_t type) {
  visualization_msgs::msg::Marker m;
  m.header(header);
  m.ns(ns);
  m.id(id);
  m.type(type);
  m.pose(to_msg(Pose2{}));
  return m;
}

geometry_msgs::msg::Vector3 vector(double x, double y, double z) {
  geometry_msgs::msg::Vector3 v;
  v.x(x);
  v.y(y);
  v.z(z);
  return v;
}

template <class Vector>  // of a message: Point or Vector3
Eigen::Vector3d finite_vector(const Vector& v) {
  const auto finite = [](double x) { return std::isfinite(x) ? x : 0.0; };
  return {finite(v.x()), finite(v.y()), finite(v.z())};
}

bool is_valid(const Obstacle& o) {
  return o.p_MO.allFinite() && o.v_MO.allFinite() && std::isfinite(o.angle) && std::isfinite(o.a) &&
         o.b > 0.0 && o.a >= o.b && o.shape <= ObstacleShape::kRectangle;
}

}  // namespace

std_msgs::msg::Header header(const Stamp& stamp, const std::string& frame) {
  std_msgs::msg::Header h;
  h.stamp(stamp);
  h.frame_id(frame);
  return h;
}

std::optional<Twist2> from_msg(const geometry_msgs::msg::Twist& msg) {
  const Twist2 twist{msg.linear().x(), msg.angular().z()};
  return is_finite(twist) ? std::optional{twist} : std::nullopt;
}

geometry_msgs::msg::Twist to_msg(const Twist2& twist) {
  geometry_msgs::msg::Twist msg;
  msg.linear().x(twist.v);
  msg.angular().z(twist.w);
  return msg;
}

const char* fault_of(const geometry_msgs::msg::Quaternion& orientation) {
  const bool zero = orientation.x() == 0.0 && orientation.y() == 0.0 && orientation.z() == 0.0 &&
                    orientation.w() == 0.0;
  return zero ? "has a zero quaternion (the identity rotation has w = 1)" : "is not finite";
}

std::optional<Pose2> from_msg(const geometry_msgs::msg::Pose& msg) {
  return finite_pose(msg.position().x(), msg.position().y(), msg.orientation());
}

geometry_msgs::msg::Pose to_msg(const Pose2& X) {
  geometry_msgs::msg::Pose msg;
  msg.position(point(X.x, X.y));
  msg.orientation(quaternion(X.theta));
  return msg;
}

geometry_msgs::msg::PoseStamped to_msg(const Pose2& X, const std_msgs::msg::Header& header) {
  geometry_msgs::msg::PoseStamped msg;
  msg.header(header);
  msg.pose(to_msg(X));
  return msg;
}

std::optional<Odometry> from_msg(const nav_msgs::msg::Odometry& msg) {
  const auto X = from_msg(msg.pose().pose());
  const auto twist = from_msg(msg.twist().twist());
  if (!X || !twist) return std::nullopt;
  return Odometry{*X, *twist};
}

std::optional<Odometry> from_msg(const nav_msgs::msg::Odometry& of_C, const Eigen::Isometry3d& X_AF,
                                 const Eigen::Isometry3d& X_CB) {
  const auto as_given = from_msg(of_C);
  const auto none = Eigen::Isometry3d::Identity().matrix();
  if (!as_given || (X_AF.matrix() == none && X_CB.matrix() == none)) return as_given;
  const auto& q = of_C.pose().pose().orientation();
  const Eigen::Isometry3d X_AC =
      X_AF * (Eigen::Translation3d(finite_vector(of_C.pose().pose().position())) *
              Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized());
  const Eigen::Vector3d v_AC = X_AC.linear() * finite_vector(of_C.twist().twist().linear());
  const Eigen::Vector3d w_AC = X_AC.linear() * finite_vector(of_C.twist().twist().angular());
  const Eigen::Vector3d v_AB = v_AC + w_AC.cross(X_AC.linear() * X_CB.translation());
  const Pose2 X_AB = in_plane(X_AC * X_CB);
  const double ahead = std::cos(X_AB.theta) * v_AB.x() + std::sin(X_AB.theta) * v_AB.y();
  return Odometry{X_AB, {ahead, w_AC.z()}};
}

std::optional<Odometry> truth_from(const nav_msgs::msg::Odometry& msg, const std::string& map) {
  const auto frame = bare_frame(msg.header().frame_id());
  return frame.empty() || frame == bare_frame(map) ? from_msg(msg) : std::nullopt;
}

nav_msgs::msg::Odometry to_msg(const Odometry& odometry, const std_msgs::msg::Header& header,
                               const std::string& child) {
  nav_msgs::msg::Odometry msg;
  msg.header(header);
  msg.child_frame_id(child);
  msg.pose().pose(to_msg(odometry.X));
  msg.twist().twist(to_msg(odometry.twist));
  return msg;
}

std::optional<Pose2> find_transform(const tf2_msgs::msg::TFMessage& msg, const std::string& parent,
                                    const std::string& child) {
  for (const auto& t : msg.transforms())
    if (t.header().frame_id() == parent && t.child_frame_id() == child)
      return finite_pose(t.transform().translation().x(), t.transform().translation().y(),
                         t.transform().rotation());
  return std::nullopt;
}

geometry_msgs::msg::TransformStamped to_transform(const Pose2& X,
                                                  const std_msgs::msg::Header& header,
                                                  const std::string& child) {
  geometry_msgs::msg::TransformStamped msg;
  msg.header(header);
  msg.child_frame_id(child);
  msg.transform().translation(vector(X.x, X.y, 0.0));
  msg.transform().rotation(quaternion(X.theta));
  return msg;
}

std::optional<Eigen::Isometry3d> from_msg(const geometry_msgs::msg::Transform& msg) {
  const auto& t = msg.translation();
  const auto& r = msg.rotation();
  const Eigen::Quaterniond q{r.w(), r.x(), r.y(), r.z()};
  const Eigen::Vector3d p{t.x(), t.y(), t.z()};
  if (!p.allFinite() || !(q.norm() > kLeastNorm) || !std::isfinite(q.norm())) return std::nullopt;
  return Eigen::Translation3d(p) * q.normalized();
}

geometry_msgs::msg::TransformStamped to_transform(const Eigen::Isometry3d& X,
                                                  const std_msgs::msg::Header& header,
                                                  const std::string& child) {
  geometry_msgs::msg::TransformStamped msg;
  msg.header(header);
  msg.child_frame_id(child);
  const Eigen::Vector3d p = X.translation();
  const Eigen::Quaterniond q{X.linear()};
  msg.transform().translation(vector(p.x(), p.y(), p.z()));
  msg.transform().rotation().x(q.x());
  msg.transform().rotation().y(q.y());
  msg.transform().rotation().z(q.z());
  msg.transform().rotation().w(q.w());
  return msg;
}

Obstacles from_msg(const tandem_msgs::msg::ObstacleArray& msg) {
  Obstacles obstacles;
  for (const auto& m : msg.obstacles()) {
    const Obstacle o{
        m.id(),    {m.center().x(), m.center().y()},     m.semi_axis_a(),          m.semi_axis_b(),
        m.angle(), {m.velocity().x(), m.velocity().y()}, ObstacleShape{m.shape()}, m.tracked()};
    if (is_valid(o))
      obstacles.all.push_back(o);
    else
      ++obstacles.refused;
  }
  return obstacles;
}

tandem_msgs::msg::ObstacleArray to_msg(std::span<const Obstacle> obstacles,
                                       const std_msgs::msg::Header& header) {
  tandem_msgs::msg::ObstacleArray msg;
  msg.header(header);
  for (const Obstacle& o : obstacles) {
    tandem_msgs::msg::Obstacle m;
    m.id(o.id);
    m.center(point(o.p_MO.x(), o.p_MO.y()));
    m.semi_axis_a(o.a);
    m.semi_axis_b(o.b);
    m.angle(o.angle);
    m.velocity(vector(o.v_MO.x(), o.v_MO.y(), 0.0));
    m.shape(static_cast<std::uint8_t>(o.shape));
    m.tracked(o.tracked);
    msg.obstacles().push_back(std::move(m));
  }
  return msg;
}

RangeScan from_msg(const sensor_msgs::msg::LaserScan& msg) {
  return {msg.angle_min(),      msg.angle_increment(), msg.range_min(), msg.range_max(),
          msg.time_increment(), msg.scan_time(),       msg.ranges()};
}

RangeReturns from_msg(const sensor_msgs::msg::PointCloud2& msg) {
  CloudLayout layout{.height = msg.height(),
                     .width = msg.width(),
                     .fields = {},
                     .is_bigendian = msg.is_bigendian(),
                     .point_step = msg.point_step(),
                     .row_step = msg.row_step()};
  for (const auto& field : msg.fields())
    layout.fields.push_back({field.name(), field.offset(), field.datatype()});
  return range_returns_of(layout, msg.data());
}

nav_msgs::msg::Path to_path(std::span<const Pose2> X, const std_msgs::msg::Header& header) {
  nav_msgs::msg::Path msg;
  msg.header(header);
  for (const Pose2& pose : X) msg.poses().push_back(to_msg(pose, header));
  return msg;
}

OccupancyPlane from_msg(const nav_msgs::msg::OccupancyGrid& msg) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr std::uint32_t kMax = std::numeric_limits<int>::max();
  OccupancyPlane plane;
  plane.X_MO = from_msg(msg.info().origin()).value_or(Pose2{kNaN, kNaN, kNaN});
  plane.resolution = static_cast<double>(msg.info().resolution());
  plane.width = static_cast<int>(std::min(msg.info().width(), kMax));
  plane.height = static_cast<int>(std::min(msg.info().height(), kMax));
  plane.percent = msg.data();
  return plane;
}

nav_msgs::msg::OccupancyGrid to_msg(const Grid& grid, const std_msgs::msg::Header& header) {
  nav_msgs::msg::OccupancyGrid msg;
  msg.header(header);
  msg.info().map_load_time(header.stamp());
  msg.info().resolution(static_cast<float>(grid.resolution));
  msg.info().width(static_cast<std::uint32_t>(grid.width));
  msg.info().height(static_cast<std::uint32_t>(grid.height));
  msg.info().origin(to_msg(Pose2{grid.origin.x(), grid.origin.y(), 0.0}));
  msg.data().reserve(grid.cells.size());
  for (const Cell cell : grid.cells)
    msg.data().push_back(cell == Cell::kOccupied ? 100 : cell == Cell::kFree ? 0 : -1);
  return msg;
}

visualization_msgs::msg::MarkerArray to_markers(std::span<const Obstacle> obstacles,
                                                const std_msgs::msg::Header& header) {
  using visualization_msgs::msg::Marker_Constants::CUBE;
  using visualization_msgs::msg::Marker_Constants::CYLINDER;
  using visualization_msgs::msg::Marker_Constants::DELETEALL;
  visualization_msgs::msg::MarkerArray msg;
  msg.markers().push_back(marker(header, "obstacles", 0, CYLINDER));
  msg.markers().back().action(DELETEALL);
  std::int32_t id = 0;
  for (const Obstacle& o : obstacles) {
    auto m = marker(header, "obstacles", ++id, is_rectangle(o) ? CUBE : CYLINDER);
    m.pose(to_msg(Pose2{o.p_MO.x(), o.p_MO.y(), o.angle}));
    m.scale(vector(2.0 * o.a, 2.0 * o.b, 0.1));
    m.color(color(0.90f, 0.45f, 0.0f, 0.5f));
    msg.markers().push_back(std::move(m));
  }
  return msg;
}

std::vector<visualization_msgs::msg::Marker> to_markers(const VirtualFixtures& fixtures,
                                                        const std_msgs::msg::Header& header) {
  std::vector<visualization_msgs::msg::Marker> markers;
  for (const ForbiddenRegion& region : fixtures.forbidden) {
    auto m = marker(header, "forbidden", static_cast<std::int32_t>(markers.size()),
                    visualization_msgs::msg::Marker_Constants::LINE_STRIP);
    for (const auto& p_MV : region.p_MV) m.points().push_back(point(p_MV.x(), p_MV.y()));
    m.points().push_back(m.points().front());
    m.scale(vector(0.05, 0.0, 0.0));
    m.color(color(0.80f, 0.10f, 0.10f, 0.9f));
    markers.push_back(std::move(m));
  }
  for (const GuidanceLine& line : fixtures.guidance) {
    auto m = marker(header, "guidance", static_cast<std::int32_t>(markers.size()),
                    visualization_msgs::msg::Marker_Constants::LINE_STRIP);
    for (const auto& p_MV : line.p_MV) m.points().push_back(point(p_MV.x(), p_MV.y()));
    m.scale(vector(0.05, 0.0, 0.0));
    m.color(color(0.0f, 0.45f, 0.70f, 0.9f));
    markers.push_back(std::move(m));
  }
  return markers;
}

visualization_msgs::msg::MarkerArray leader_markers(const Pose2& X_ML, const Pose2& X_MB,
                                                    const std_msgs::msg::Header& header) {
  using visualization_msgs::msg::Marker_Constants::ARROW;
  using visualization_msgs::msg::Marker_Constants::LINE_STRIP;
  visualization_msgs::msg::MarkerArray msg;
  auto arrow = marker(header, "leader", 0, ARROW);
  arrow.pose(to_msg(X_ML));
  arrow.scale(vector(0.5, 0.1, 0.1));
  arrow.color(color(0.0f, 0.45f, 0.70f, 1.0f));
  msg.markers().push_back(std::move(arrow));
  auto leash = marker(header, "leash", 1, LINE_STRIP);
  leash.points({point(X_MB.x, X_MB.y), point(X_ML.x, X_ML.y)});
  leash.scale(vector(0.03, 0.0, 0.0));
  leash.color(color(0.0f, 0.45f, 0.70f, 0.6f));
  msg.markers().push_back(std::move(leash));
  return msg;
}

visualization_msgs::msg::MarkerArray goal_markers(std::span<const Pose2> X_MG,
                                                  std::span<const double> belief,
                                                  const std_msgs::msg::Header& header) {
  using visualization_msgs::msg::Marker_Constants::ARROW;
  using visualization_msgs::msg::Marker_Constants::TEXT_VIEW_FACING;
  visualization_msgs::msg::MarkerArray msg;
  for (std::size_t i = 0; i < X_MG.size() && i < belief.size(); ++i) {
    const auto share = static_cast<float>(belief[i]);
    auto arrow = marker(header, "goals", static_cast<int>(i), ARROW);
    arrow.pose(to_msg(X_MG[i]));
    arrow.scale(vector(0.6, 0.12, 0.12));
    arrow.color(color(0.0f, 0.62f, 0.45f, 0.2f + 0.8f * share));
    msg.markers().push_back(std::move(arrow));
    auto text = marker(header, "belief", static_cast<int>(i), TEXT_VIEW_FACING);
    text.pose(to_msg(X_MG[i]));
    text.pose().position().z(0.4);
    text.scale(vector(0.0, 0.0, 0.25));
    text.color(color(1.0f, 1.0f, 1.0f, 1.0f));
    text.text(std::to_string(std::lround(100.0 * belief[i])) + " %");
    msg.markers().push_back(std::move(text));
  }
  return msg;
}

}  // namespace tandem
