// SPDX-License-Identifier: Apache-2.0
#include "octomap_builder/octomap_builder_node.hpp"

#include "map/octomap_file.hpp"
#include "runtime/component.hpp"
#include "topics.hpp"

namespace tandem {
namespace {

constexpr double kRest = 2.0;      // times as long as the last map took: to hear odometry meanwhile
constexpr double kPatience = 1.0;  // [s] /tf_static may come later than the first scan

bool is_zero(const Stamp& stamp) { return stamp.sec() == 0 && stamp.nanosec() == 0; }

}  // namespace

OctomapBuilderNode::OctomapBuilderNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<OctomapBuilderNodeParams>()},
      outline_{footprint_of(params_->robot)},
      map_{params_->map},
      scanner_{"scan", "scan_pose", mounting("scan_pose", params_->scan_pose)},
      camera_{"cloud_in", "cloud_pose", mounting("cloud_pose", params_->cloud_pose)},
      robot_{node, params_->input, [this](double stamp) { on_odometry(stamp); }},
      octomap_{node.create_publisher(topics::octomap_local)} {
  subscribe();
  timer_ = node.create_timer(params_->period, [this] { publish_if_due(); });
}

void OctomapBuilderNode::subscribe() {
  tf_static_ = node_.create_subscription(topics::tf_static, [this](const auto& msg) {
    for (const auto& t : msg.transforms())
      if (const auto X_PC = from_msg(t.transform()))
        frames_.set(t.header().frame_id(), t.child_frame_id(), *X_PC);
      else
        node_.log().error_every(1.0, "/tf_static of `{}` is not finite: dropped",
                                t.child_frame_id());
  });
  scan_ = node_.create_subscription(topics::scan, [this](const auto& msg) { on_scan(msg); });
  cloud_ = node_.create_subscription(topics::cloud_in, [this](const auto& msg) { on_cloud(msg); });
  reset_ = node_.create_service(services::reset, [this](const auto&, auto& response) {
    map_.clear();
    response.success(true);
    response.message("all that was seen is forgotten");
  });
}

void OctomapBuilderNode::on_odometry(double stamp) {
  const auto robot = robot_.state();
  if (!robot) return;
  poses_.add(robot->X_MB, robot->twist, stamp);
  map_.stand(outline_, robot->X_MB, sweep_height(*params_), node_.now());
}

void OctomapBuilderNode::on_scan(const sensor_msgs::msg::LaserScan& msg) {
  const RangeScan scan = from_msg(msg);
  if (const std::string error = error_of(scan); !error.empty()) {
    node_.log().error_every(1.0, "scan refused: {}", error);
    return;
  }
  const Stamp& stamp = msg.header().stamp();
  const auto pose_after = [&](double t) { return pose_at(stamp, t); };
  if (const auto X_BS = place_of(scanner_, msg.header().frame_id()))
    insert(scanner_, looks_of(scan, *X_BS, pose_after), stamp);
}

void OctomapBuilderNode::on_cloud(const sensor_msgs::msg::PointCloud2& msg) {
  Echoes echoes = from_msg(msg);
  if (!echoes.error.empty()) {
    node_.log().error_every(1.0, "cloud_in refused: {}", echoes.error);
    return;
  }
  const auto X_BS = place_of(camera_, msg.header().frame_id());
  if (!X_BS) return;
  const Stamp& stamp = msg.header().stamp();
  std::optional<std::vector<Look>> looks;
  if (const auto X_MB = pose_at(stamp, 0.0))
    looks = {Look{std::move(echoes), in_space(*X_MB) * *X_BS}};
  insert(camera_, looks, stamp);
}

// Where the sensor is on the robot; says once in a while what is missing.
std::optional<Eigen::Isometry3d> OctomapBuilderNode::place_of(Sensor& sensor,
                                                              const std::string& frame) {
  if (sensor.X_BS) return sensor.X_BS;
  const std::string& base = params_->input.frames.base;
  const auto X_BS = frames_.pose(base, frame);
  if (X_BS) {
    sensor.unplaced.reset();
    return X_BS;
  }
  if (!sensor.unplaced) sensor.unplaced = node_.steady_now();
  if (node_.steady_now() - *sensor.unplaced > kPatience)
    node_.log().error_every(5.0,
                            "{} dropped: /tf_static does not say where its frame `{}` is on `{}`; "
                            "publish that (robot_state_publisher, static_transform_publisher), or "
                            "set the parameter {}",
                            sensor.topic, frame, base, sensor.parameter);
  return std::nullopt;
}

void OctomapBuilderNode::insert(const Sensor& sensor, const std::optional<std::vector<Look>>& looks,
                                const Stamp& stamp) {
  if (!looks) {
    node_.log().warn_every(1.0, "{} dropped: {}", sensor.topic,
                           robot_.state() ? "no odometry of its time" : "not localised");
    return;
  }
  if (!map_.insert(*looks, node_.now())) {
    const Eigen::Vector3d p_MS = looks->back().X_MS.translation();
    node_.log().error_every(1.0, "{} dropped: ({:.0f}, {:.0f}) is farther than an OctoMap reaches",
                            sensor.topic, p_MS.x(), p_MS.y());
    return;
  }
  unsent_ = stamp;
  publish_if_due();
}

// So long after the stamp; a message without one is of now.
std::optional<Pose2> OctomapBuilderNode::pose_at(const Stamp& stamp, double after) {
  const auto robot = robot_.state();
  if (!robot) return std::nullopt;
  return is_zero(stamp) ? robot->X_MB : poses_.at(rt::to_seconds(stamp) + after);
}

void OctomapBuilderNode::publish_if_due() {
  const double now = node_.now(), began = node_.steady_now();
  if (!unsent_ || began < rested_ || (now >= sent_ && now - sent_ < params_->period)) return;
  octomap_msgs::msg::Octomap msg;
  msg.header(header(*unsent_, params_->input.frames.map));
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(map_.tree().getResolution());
  msg.data(encode_octomap(map_.tree()));
  octomap_.publish(msg);
  unsent_.reset();
  sent_ = now;
  const double end = node_.steady_now();
  rested_ = end + kRest * (end - began);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::OctomapBuilderNode, "octomap_builder")
