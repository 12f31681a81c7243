// SPDX-License-Identifier: Apache-2.0
#include "octomap_builder/octomap_builder_node.hpp"

#include "map/octomap_file.hpp"
#include "runtime/component.hpp"
#include "topics.hpp"

namespace tandem {
namespace {

bool is_zero(const Stamp& stamp) { return stamp.sec() == 0 && stamp.nanosec() == 0; }

}  // namespace

OctomapBuilderNode::OctomapBuilderNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<OctomapBuilderNodeParams>()},
      map_{params_->map},
      X_BScan_{mounting("scan_pose", params_->scan_pose)},
      X_BCloud_{mounting("cloud_pose", params_->cloud_pose)},
      robot_{node, params_->input,
             [this](double stamp) {
               if (const auto robot = robot_.state()) poses_.add(robot->X_MB, robot->twist, stamp);
             }},
      octomap_{node.create_publisher(topics::octomap_local)} {
  subscribe();
  timer_ = node.create_timer(params_->period, [this] { publish_if_due(); });
}

void OctomapBuilderNode::subscribe() {
  scan_ = node_.create_subscription(topics::scan, [this](const sensor_msgs::msg::LaserScan& msg) {
    const Echoes echoes = from_msg(msg);
    if (echoes.error.empty())
      insert("scan", echoes, msg.header(), X_BScan_);
    else
      node_.log().error_every(1.0, "scan refused: {}", echoes.error);
  });
  cloud_ =
      node_.create_subscription(topics::cloud_in, [this](const sensor_msgs::msg::PointCloud2& msg) {
        const Echoes echoes = from_msg(msg);
        if (echoes.error.empty())
          insert("cloud_in", echoes, msg.header(), X_BCloud_);
        else
          node_.log().error_every(1.0, "cloud_in refused: {}", echoes.error);
      });
  reset_ = node_.create_service(services::reset, [this](const auto&, auto& response) {
    map_.clear();
    response.success(true);
    response.message("all that was seen is forgotten");
  });
}

void OctomapBuilderNode::insert(const char* topic, const Echoes& echoes,
                                const std_msgs::msg::Header& header,
                                const Eigen::Isometry3d& X_BS) {
  const auto X_MB = pose_at(header.stamp());
  if (!X_MB) {
    node_.log().warn_every(1.0, "{} dropped: {}", topic,
                           robot_.state() ? "no odometry of its time" : "not localised");
    return;
  }
  if (!map_.insert(echoes, in_space(*X_MB) * X_BS, node_.now())) {
    node_.log().error_every(1.0, "{} dropped: ({:.0f}, {:.0f}) is farther than an OctoMap reaches",
                            topic, X_MB->x, X_MB->y);
    return;
  }
  unsent_ = header.stamp();
  publish_if_due();
}

// A message without a stamp is one of now.
std::optional<Pose2> OctomapBuilderNode::pose_at(const Stamp& stamp) {
  const auto robot = robot_.state();
  if (!robot) return std::nullopt;
  return is_zero(stamp) ? robot->X_MB : poses_.at(rt::to_seconds(stamp));
}

void OctomapBuilderNode::publish_if_due() {
  const double now = node_.now();
  if (!unsent_ || (now >= sent_ && now - sent_ < params_->period)) return;
  octomap_msgs::msg::Octomap msg;
  msg.header(header(*unsent_, params_->input.frames.map));
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(map_.tree().getResolution());
  msg.data(encode_octomap(map_.tree()));
  octomap_.publish(msg);
  unsent_.reset();
  sent_ = now;
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::OctomapBuilderNode, "octomap_builder")
