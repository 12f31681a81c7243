// SPDX-License-Identifier: Apache-2.0
// Drives over DDS with faults of frames, timestamps and QoS, drawn by seed. A person pushes forward
// in a room; the nodes must keep the robot off the walls or report why it stands.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem::test {

/// The faults on the wire.
struct WireFault {
  std::string name;
  std::string slash = {};         ///< prefix of each frame name
  std::string map_frame = "map";  ///< frame of octomap_binary
  bool map_lies = false;          ///< the walls are placed as in odom, whatever the frame is called
  bool is_chain = false;          ///< map → odom_combined → odom
  bool is_inverse = false;        ///< odom → map is published instead of map → odom
  bool has_two_parents = false;   ///< a second publisher sends building → odom
  bool has_second_odom = false;   ///< a second publisher sends odom that is 5 s old
  bool sees = false;              ///< the robot uses its scanner instead of a map
  double sensor_clock = 0.0;      ///< [s] offset of the scanner's clock into the future
  rt::QoS odom = rt::kDefault, map = rt::kLatched, scan = rt::kSensorData;
  /// Text that the log or the reason must contain; the robot may stand then. Empty: it must drive.
  std::string named = {};
};

inline const std::vector<WireFault>& wire_faults() {
  static const rt::QoS volatile_map{rt::Reliability::kReliable, rt::Durability::kVolatile, 1};
  static const std::vector<WireFault> faults{
      {.name = "map in odom", .map_frame = "odom"},
      {.name = "leading slashes", .slash = "/"},
      {.name = "odom_combined between", .is_chain = true},
      {.name = "odom_combined, map in odom", .map_frame = "odom", .is_chain = true},
      {.name = "inverse transform", .is_inverse = true},
      {.name = "two parents", .has_two_parents = true, .named = "has two parents"},
      {.name = "scanner 2 s late",
       .sees = true,
       .sensor_clock = -2.0,
       .named = "s behind odometry's"},
      {.name = "scanner 2 s ahead",
       .sees = true,
       .sensor_clock = 2.0,
       .named = "s ahead of odometry's"},
      {.name = "odom best effort", .odom = rt::kBestEffort(10)},
      {.name = "octomap volatile", .map = volatile_map},
      {.name = "scan best effort", .sees = true, .scan = rt::kBestEffort(1)},
      {.name = "scan reliable", .sees = true, .scan = rt::kDefault},
      {.name = "second odom, old stamps", .has_second_odom = true, .named = "late by its stamp"},
  };
  return faults;
}

/// One drive. The simulated base, localiser, scanner and map_server are one node; the other nodes
/// run in this process as they do in `tandem run`. Simulated time runs at half speed, or slower if
/// the computer falls behind.
class WireDrive {
 public:
  static constexpr double kDuration = 7.0;  // [s] simulated
  static constexpr double kRoom = 3.0;      // [m] from the centre to each wall

  WireDrive(unsigned seed, const WireFault& fault)
      : fault_{fault},
        random_{seed},
        X_MO_{draw(0.6, 0.9), draw(-0.6, 0.6), draw(-1.0, 1.0)},
        sim_{sim_params(), robot(), std::make_shared<const StaticMap>(slice(room({}), {})), seed},
        stick_{draw(0.3, 0.8), draw(-0.15, 0.15)} {
    start_ = {draw(-0.7, 0.7), draw(-0.7, 0.7), draw(-std::numbers::pi, std::numbers::pi)};
    sim_.reset(start_, seed);
    open();
  }

  void run() {
    tick_ = node_.create_wall_timer(kTick / kSpeed, [this] { tick(); });
    while (sim_.state().t < kDuration) node_.spin_some(0.1);
    tick_ = {};
    log_ = captured_.text();
  }

  [[nodiscard]] unsigned contacts() const { return sim_.contacts().count; }
  [[nodiscard]] double travelled() const {
    return (sim_.state().X_MB.position() - start_.position()).norm();
  }
  [[nodiscard]] bool has_driven() const { return travelled() > 0.3; }
  /// Smallest gap to a wall [m], at most 1.
  [[nodiscard]] double closest() const { return sim_.min_clearance(); }
  /// True if the expected text was reported or, if none is expected, the robot has driven.
  [[nodiscard]] bool is_as_wanted() const {
    if (fault_.named.empty()) return has_driven();
    return (log_ + said_).find(fault_.named) != std::string::npos;
  }
  /// All reasons that arbitration reported.
  [[nodiscard]] const std::string& reasons() const { return said_; }

 private:
  static constexpr double kTick = 0.01;  // [s] simulated
  static constexpr double kSpeed = 0.5;  // simulated time per real time
  static constexpr double kResolution = 0.05;

  // These bounds allow for a computer under other load.
  static RobotParams robot() {
    RobotParams params;
    params.sensor_delay = 0.1;
    params.command_delay = 0.1;
    params.base_timeout = 0.2;
    return params;
  }
  static DiffDriveSimParams sim_params() {
    DiffDriveSimParams params;
    params.sensor_delay_fraction = 0.2;
    return params;
  }
  static std::map<std::string, std::string> robot_values() {
    return {{"sensor_delay", "0.1"}, {"command_delay", "0.1"}, {"base_timeout", "0.2"}};
  }

  // The walls in frame F, as voxels of 1 cm; X_FM is the map's origin in F.
  static octomap::OcTree room(const Pose2& X_FM) {
    octomap::OcTree tree(kResolution);
    const auto mark = [&](double x, double y) {
      const Eigen::Vector2d p = transform(X_FM, Eigen::Vector2d{x, y});
      for (const float z : {0.12F, 0.32F, 0.52F})
        tree.updateNode(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), z),
                        true);
    };
    for (double along = -kRoom; along <= kRoom; along += 0.01)
      for (double across = kRoom; across < kRoom + 0.1; across += 0.01) {
        mark(along, across);
        mark(along, -across);
        mark(across, along);
        mark(-across, along);
      }
    return tree;
  }

  [[nodiscard]] double draw(double least, double most) {
    return std::uniform_real_distribution{least, most}(random_);
  }
  [[nodiscard]] std::string frame(const std::string& name) const { return fault_.slash + name; }
  [[nodiscard]] Stamp stamp(double t) const {
    return rt::to_stamp(std::llround(1e9 * std::max(0.0, kBegin + t)));
  }

  void open() {
    const auto load = [&](const std::string& name, std::map<std::string, std::string> values) {
      values["use_sim_time"] = "true";
      rt::NodeOptions options;
      options.name = name;
      for (const auto& [key, value] : values) options.parameters.values[key] = {value, "test"};
      components_.push_back(rt::load_component(name, options));
    };
    auto values = robot_values();
    values["map_source"] = fault_.sees ? "local" : "static";
    load("safety_filter", values);
    load("arbitration", {{"policy", "manual"}, {"user_timeout", "0.3"}});
    if (fault_.sees) load("octomap_builder", {{"scan_pose", "[0.0, 0.0, 0.3, 0.0, 0.0, 0.0]"}});
    if (!fault_.sees) publish_map();
  }

  void publish_map() {
    const bool is_in_odom = fault_.map_lies || fault_.map_frame == "odom";
    octomap_msgs::msg::Octomap msg;
    msg.header(header({}, frame(fault_.map_frame)));
    msg.binary(true);
    msg.id("OcTree");
    msg.resolution(kResolution);
    msg.data(encode_octomap(room(is_in_odom ? inverse(X_MO_) : Pose2{})));
    map_.publish(msg);
  }

  void tick() {
    const double t = kTick * static_cast<double>(++ticks_);
    sim_.advance_to(t);
    rosgraph_msgs::msg::Clock clock;
    clock.clock(stamp(t));
    clock_.publish(clock);
    if (ticks_ % 2 == 0) publish_odometry();
    if (ticks_ % 3 == 0) user_.publish(to_msg(stick_));
    if (fault_.sees && ticks_ % 10 == 0) publish_scan(t);
    if (ticks_ % 100 == 0 && fault_.map.durability == rt::Durability::kVolatile) publish_map();
  }

  void publish_odometry() {
    const OdometryReport report = sim_.odometry();
    const Pose2 X_OB = compose(inverse(X_MO_), compose(report.X_MW, report.X_WB));
    tf_.publish(transforms(report.t, X_OB));
    odom_.publish(to_msg(Odometry{X_OB, report.twist}, header(stamp(report.t), frame("odom")),
                         frame("base_link")));
    if (fault_.has_two_parents) {
      tf2_msgs::msg::TFMessage other;
      other.transforms().push_back(
          to_transform({2.0, 1.0, 0.5}, header(stamp(report.t), "building"), "odom"));
      rivals_tf_.publish(other);
    }
    if (fault_.has_second_odom)
      rivals_odom_.publish(to_msg(Odometry{compose(inverse(X_MO_), start_), {}},
                                  header(stamp(report.t - 5.0), "odom"), "base_link"));
  }

  [[nodiscard]] tf2_msgs::msg::TFMessage transforms(double t, const Pose2& X_OB) const {
    tf2_msgs::msg::TFMessage msg;
    const auto add = [&](const std::string& parent, const std::string& child, const Pose2& X) {
      msg.transforms().push_back(to_transform(X, header(stamp(t), frame(parent)), frame(child)));
    };
    const Pose2 X_MC{0.4, -0.3, 0.2};
    if (fault_.is_inverse) {
      add("odom", "map", inverse(X_MO_));
    } else if (fault_.is_chain) {
      add("map", "odom_combined", X_MC);
      add("odom_combined", "odom", compose(inverse(X_MC), X_MO_));
    } else {
      add("map", "odom", X_MO_);
    }
    add("odom", "base_link", X_OB);
    return msg;
  }

  void publish_scan(double t) {
    constexpr int kBeams = 360;
    sensor_msgs::msg::LaserScan msg;
    msg.header(header(stamp(t + fault_.sensor_clock), "laser"));
    msg.angle_min(static_cast<float>(beam_angle(0, kBeams, kAllAround)));
    msg.angle_increment(static_cast<float>(kAllAround / kBeams));
    msg.angle_max(static_cast<float>(beam_angle(kBeams - 1, kBeams, kAllAround)));
    msg.range_min(0.05F);
    msg.range_max(10.0F);
    for (int i = 0; i < kBeams; ++i)
      msg.ranges().push_back(static_cast<float>(sim_.beam(sim_.state().X_MB, i, kBeams, 10.0)));
    scan_.publish(msg);
  }

  // [s] initial simulated time, so that timestamps can be old
  static constexpr double kBegin = 1000.0;

  WireFault fault_;
  std::mt19937 random_;
  Pose2 X_MO_;  // pose of odom, about 1 m from the map's origin
  DiffDriveSim sim_;
  Twist2 stick_;
  Pose2 start_;
  std::string said_, log_;
  long ticks_ = 0;

  CapturedLog captured_;
  rt::Node node_{"world"}, rival_{"rival"};
  rt::Publisher<rosgraph_msgs::msg::Clock> clock_ = node_.create_publisher(topics::clock);
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom, fault_.odom);
  rt::Publisher<tf2_msgs::msg::TFMessage> tf_ = node_.create_publisher(topics::tf);
  rt::Publisher<octomap_msgs::msg::Octomap> map_ =
      node_.create_publisher(topics::octomap_binary, fault_.map);
  rt::Publisher<sensor_msgs::msg::LaserScan> scan_ =
      node_.create_publisher(topics::scan, fault_.scan);
  rt::Publisher<geometry_msgs::msg::Twist> user_ = node_.create_publisher(topics::cmd_vel_user);
  rt::Publisher<nav_msgs::msg::Odometry> rivals_odom_ =
      fault_.has_second_odom ? rival_.create_publisher(topics::odom)
                             : rt::Publisher<nav_msgs::msg::Odometry>{};
  rt::Publisher<tf2_msgs::msg::TFMessage> rivals_tf_ =
      fault_.has_two_parents ? rival_.create_publisher(topics::tf)
                             : rt::Publisher<tf2_msgs::msg::TFMessage>{};
  rt::Subscription cmd_vel_ = node_.create_subscription(topics::cmd_vel, [this](const auto& msg) {
    if (const auto twist = from_msg(msg)) sim_.command(*twist, sim_.state().t);
  });
  rt::Subscription status_ =
      node_.create_subscription(topics::arbitration_status, [this](const auto& msg) {
        if (said_.find(msg.reason()) == std::string::npos) said_ += msg.reason() + "; ";
      });
  std::vector<rt::RunningComponent> components_;
  rt::Timer tick_;
};

}  // namespace tandem::test
