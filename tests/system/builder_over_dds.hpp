// SPDX-License-Identifier: Apache-2.0
// Runs octomap_builder over real DDS with a scanner and a camera whose data the test sets.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "support/point_cloud.hpp"
#include "system/one_component.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem::test {

inline constexpr double kBeamTurn = 2.0 * std::numbers::pi / 360;

// A robot at (2.013, 1.017), turned left, in a round room of 3 m radius. No range return is near
// the border of a voxel.
inline const Pose2 kRobotOnMap{2.013, 1.017, std::numbers::pi / 2.0};

class BuilderOverDds : public OneComponent {
 protected:
  explicit BuilderOverDds(Values parameters = {}) {
    parameters["map_is_odom"] = "true";
    builder_.emplace(load("octomap_builder", parameters));
    status_in_ = node_.create_subscription(topics::sensing_status, [this](const auto& msg) {
      reason_ = msg.reason();
      code_ = from_msg(msg.reason_code());
      ++statuses_;
    });
    maps_in_ = node_.create_subscription(topics::octomap_local, [this](const auto& msg) {
      const auto decoded =
          decode_octomap({msg.id(), msg.binary(), msg.resolution()}, msg.data(), true);
      ASSERT_TRUE(decoded.tree) << decoded.error;
      tree_ = std::make_unique<octomap::OcTree>(*decoded.tree);
      frame_ = msg.header().frame_id();
      ++maps_;
    });
    publish_frame("base_link", "base_scan", Eigen::Isometry3d{Eigen::Translation3d(0, 0, 0.3)});
    odometry_ = node_.create_wall_timer(0.02, [this] {
      odom_.publish(to_msg(Odometry{robot_, {}}, header(node_.stamp(), "odom"), "base_link"));
    });
  }

  void publish_frame(const std::string& parent, const std::string& child,
                     const Eigen::Isometry3d& X_PC) {
    tf2_msgs::msg::TFMessage msg;
    msg.transforms().push_back(to_transform(X_PC, header(node_.stamp(), parent), child));
    tf_static_.publish(msg);
  }
  [[nodiscard]] sensor_msgs::msg::LaserScan scan(float range) const {
    sensor_msgs::msg::LaserScan msg;
    msg.header(header(node_.stamp(), "base_scan"));
    msg.angle_increment(static_cast<float>(kBeamTurn));
    msg.range_max(10.0F);
    msg.ranges().assign(360, range);
    return msg;
  }
  [[nodiscard]] bool wait_for_maps(long more) {
    const long before = maps_;
    const auto beat = node_.create_wall_timer(0.05, [this] { scan_.publish(scan(3.0F)); });
    return wait_until([&] { return maps_ >= before + more; });
  }
  // Publishes scans, modified by `spoil`, until everything expected has arrived or the time is up.
  [[nodiscard]] bool wait_with_scans(const std::function<void(sensor_msgs::msg::LaserScan&)>& spoil,
                                     const std::function<bool()>& done) {
    const auto beat = node_.create_wall_timer(0.05, [&] {
      auto msg = scan(3.0F);
      spoil(msg);
      scan_.publish(msg);
    });
    return wait_until(done);
  }
  [[nodiscard]] bool says(const std::string& part) const {
    return reason_ && (part.empty() ? reason_->empty() : reason_->find(part) != std::string::npos);
  }
  // A cloud of a pole on the robot's left at the scanner's height, or an empty cloud.
  [[nodiscard]] rt::Timer camera_that_sees(bool points) {
    return node_.create_wall_timer(0.05, [this, points] {
      std::vector<Eigen::Vector3f> seen;
      if (points) seen.emplace_back(0.01F, 1.5F, 0.0F);
      cloud_.publish(cloud_of(seen, header(node_.stamp(), "base_scan")));
    });
  }
  [[nodiscard]] bool is_occupied(double x, double y) const {
    const auto* voxel = tree_->search(x, y, 0.3);
    return voxel != nullptr && tree_->isNodeOccupied(voxel);
  }

  CapturedLog log_;
  std::optional<rt::RunningComponent> builder_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<sensor_msgs::msg::LaserScan> scan_ = node_.create_publisher(topics::scan);
  rt::Publisher<sensor_msgs::msg::PointCloud2> cloud_ = node_.create_publisher(topics::cloud_in);
  rt::Publisher<tf2_msgs::msg::TFMessage> tf_static_ = node_.create_publisher(topics::tf_static);
  rt::Subscription maps_in_, status_in_;
  rt::Timer odometry_;
  std::unique_ptr<octomap::OcTree> tree_;
  std::string frame_;
  Pose2 robot_ = kRobotOnMap;
  std::optional<std::string> reason_;
  Reason code_ = Reason::kOther;
  long maps_ = 0, statuses_ = 0;
};

}  // namespace tandem::test
