// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/octomap_builder_node.hpp"

#include <cmath>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kRest = 2.0;  // times the last map's duration: pause in which odometry is handled
constexpr double kReminder = 30.0;  // [s] interval at which a sensor's problem is logged again
constexpr double kPatience = 1.0;   // [s] /tf_static may arrive after the first scan

constexpr const char *kRefused = "refused", *kDropped = "dropped";  // what happened to a message

bool is_zero(const Stamp& stamp) { return stamp.sec() == 0 && stamp.nanosec() == 0; }

}  // namespace

rt::Interface OctomapBuilderNode::interface() {
  return rt::Interface{.subscribes = {topics::scan, topics::cloud_in},
                       .publishes = {topics::octomap_local, topics::sensing_status},
                       .serves = {services::reset}} +
         RobotStateInput::interface() + Diagnostics::interface();
}

OctomapBuilderNode::OctomapBuilderNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      outline_{footprint_of(params_->robot)},
      map_{params_->map},
      body_{outline_},
      reader_{params_->scan, params_->map.min_range},
      scanner_{"scan", "scan_pose", mounting("scan_pose", params_->scan_pose),
               SensorWatch{"scan", params_->watch, params_->map.resolution}},
      camera_{"cloud_in", "cloud_pose", mounting("cloud_pose", params_->cloud_pose),
              SensorWatch{"cloud_in", params_->watch, params_->map.resolution}},
      robot_{node, params_->input, [this](double stamp) { on_odometry(stamp); }},
      octomap_{node.create_publisher(topics::octomap_local)},
      status_{node.create_publisher(topics::sensing_status)},
      diagnostics_{node, {topics::octomap_local.name, topics::sensing_status.name}} {
  subscribe();
  timer_ = node.create_timer(params_->period, [this] { publish_if_due(); });
  status_timer_ = node.create_wall_timer(kStatusPeriod, [this] { publish_status(); });
  time_jump_ = node.on_time_jump([this] {
    for (Sensor* sensor : {&scanner_, &camera_}) sensor->watch.on_time_jump(node_.now());
  });
}

void OctomapBuilderNode::subscribe() {
  scan_ = node_.create_subscription(topics::scan, [this](const auto& msg) { on_scan(msg); });
  cloud_ = node_.create_subscription(topics::cloud_in, [this](const auto& msg) { on_cloud(msg); });
  reset_ = node_.create_service(services::reset, [this](const auto&, auto& response) {
    map_.clear();
    reader_.forget();
    scanner_.watch.forget();
    camera_.watch.forget();
    response.success(true);
    response.message("the local map was cleared");
  });
}

void OctomapBuilderNode::on_odometry(double stamp) {
  const auto robot = robot_.state();
  if (!robot) return;
  poses_.add(robot->X_MB, robot->twist, stamp);
  odometry_.add(robot_.odometry(), robot->twist, stamp);
  map_.stand(outline_, robot->X_MB, sweep_height(*params_), node_.now());
}

void OctomapBuilderNode::on_scan(const sensor_msgs::msg::LaserScan& msg) {
  const auto X_BS = place_of(scanner_, msg.header());
  if (!X_BS) return;
  RangeScan scan = from_msg(msg);
  const ScanReading reading = reader_.read(scan, *X_BS, body_);
  if (!reading.error.empty()) return give_up(scanner_, kRefused, reading.error);
  check_oddities(scan);
  note_own_body(scanner_, reading.own_body);
  const Stamp& stamp = msg.header().stamp();
  std::string unplaced;  // why the mount is unknown at a later beam
  const auto pose_after = [&](double t) -> std::optional<Eigen::Isometry3d> {
    const auto X_MB = pose_at(stamp, t);
    const Placing on_robot = place_after(scanner_, msg.header(), t);
    if (!on_robot.X_AB) unplaced = why_unplaced(scanner_, msg.header().frame_id(), on_robot);
    if (!X_MB || !on_robot.X_AB) return std::nullopt;
    return in_space(*X_MB) * *on_robot.X_AB;
  };
  auto looks = looks_of(scan, pose_after, reader_.no_return());
  if (!looks) return give_up(scanner_, kDropped, unplaced.empty() ? why_no_pose(stamp) : unplaced);
  for (Look& look : *looks) body_.drop(look.echoes, *X_BS);
  take(scanner_, {{reading.seen, *X_BS, odometry_at(stamp), reading.valid_share},
                  reading.composition,
                  std::move(*looks),
                  stamp});
}

void OctomapBuilderNode::on_cloud(const sensor_msgs::msg::PointCloud2& msg) {
  RangeReturns echoes = from_msg(msg);
  if (!echoes.error.empty()) return give_up(camera_, kRefused, echoes.error);
  const auto X_BS = place_of(camera_, msg.header());
  if (!X_BS) return;
  note_own_body(camera_, body_.drop(echoes, *X_BS));
  const Stamp& stamp = msg.header().stamp();
  const auto X_MB = pose_at(stamp, 0.0);
  if (!X_MB) return give_up(camera_, kDropped, why_no_pose(stamp));
  take(camera_,
       {{echoes, *X_BS, odometry_at(stamp)}, {}, {Look{echoes, in_space(*X_MB) * *X_BS}}, stamp});
}

// The sensor's pose on the robot; logs from time to time what is missing.
std::optional<Eigen::Isometry3d> OctomapBuilderNode::place_of(
    Sensor& sensor, const std_msgs::msg::Header& sensor_header) {
  const std::string& base = params_->input.frames.base;
  const std::string& frame = sensor_header.frame_id();
  if (robot_.frames().is_world(frame)) {
    const std::string why = fmt::format(
        "it is given in frame `{}`, which does not move with the robot, so the sensor's position "
        "is unknown; publish it in the sensor's frame",
        frame);
    sensor.watch.on_trouble("is dropped: " + why, node_.now());
    node_.log().error_every(5.0, "{} dropped: {}", sensor.topic, why);
    return std::nullopt;
  }
  if (sensor.X_BS) return sensor.X_BS;
  const Placing on_robot = robot_.frames().place(base, frame, sensor_header.stamp());
  if (on_robot.X_AB) {
    sensor.unplaced.reset();
    return on_robot.X_AB;
  }
  if (!sensor.unplaced) sensor.unplaced = node_.steady_now();
  const std::string why = why_unplaced(sensor, frame, on_robot);
  sensor.watch.on_trouble("is dropped: " + why, node_.now());
  if (node_.steady_now() - *sensor.unplaced > kPatience)
    node_.log().error_every(5.0, "{} dropped: {}", sensor.topic, why);
  return std::nullopt;
}

std::string OctomapBuilderNode::why_unplaced(const Sensor& sensor, const std::string& frame,
                                             const Placing& on_robot) const {
  return fmt::format(
      "/tf_static does not say where its frame `{}` is on `{}`, nor does /tf ({}); publish that "
      "transform (robot_state_publisher, static_transform_publisher), or set the parameter {}",
      frame, params_->input.frames.base, on_robot.refusal, sensor.parameter);
}

// The sensor's pose on the robot `after` seconds after the stamp: a turret turns during a scan.
Placing OctomapBuilderNode::place_after(const Sensor& sensor, const std_msgs::msg::Header& header,
                                        double after) const {
  if (sensor.X_BS) return {.X_AB = sensor.X_BS};
  const Stamp& stamp = header.stamp();
  return robot_.frames().place(
      params_->input.frames.base, header.frame_id(),
      is_zero(stamp) ? stamp : rt::to_stamp(std::llround(1e9 * (rt::to_seconds(stamp) + after))));
}

// Reports a message that could not be used, with the reason.
void OctomapBuilderNode::give_up(Sensor& sensor, const char* what, const std::string& why) {
  const bool is_refused = std::string_view{what} == kRefused;
  const auto level = is_refused ? rt::LogLevel::kError : rt::LogLevel::kWarn;
  sensor.watch.on_trouble(fmt::format("is {}: {}", what, why), node_.now());
  node_.log().write_every(1.0, level, std::string{sensor.topic} + what,
                          fmt::format("{} {}: {}", sensor.topic, what, why));
}

// Warns about suspicious values in a readable scan. If its beam times are invalid, all beams get
// the same time.
void OctomapBuilderNode::check_oddities(RangeScan& scan) {
  if (const auto name = reader_.missing_name(scan))
    node_.log().warn(
        "scan: most beams have been {0} for many scans; if the driver sends that when nothing is "
        "in range, add {0} to the parameter no_return",
        *name);
  if (const std::string error = time_error_of(scan); !error.empty()) {
    node_.log().warn_every(
        kReminder, "scan: {}; all beams are treated as measured at the same instant", error);
    scan.time_increment = 0.0;
  }
}

void OctomapBuilderNode::note_own_body(Sensor& sensor, std::size_t echoes) {
  sensor.own_body = echoes;
  if (echoes == 0 || std::exchange(sensor.own_body_told, true)) return;
  node_.log().warn(
      "{}: {} returns of one measurement lie inside the robot's outline and are dropped, from now "
      "on without a log line: they hit the robot itself (if not, length, width, footprint or the "
      "sensor's mounting is wrong: {}, /tf_static)",
      sensor.topic, echoes, sensor.parameter);
}

void OctomapBuilderNode::take(Sensor& sensor, const Sight& sight) {
  const LookUse use = sensor.watch.assess(sight.watched, sight.composition, node_.now());
  if (use == LookUse::kNone || (use == LookUse::kTake && !insert(sensor, sight.looks))) return;
  sensor.watch.on_taken(node_.now());
  unsent_ = sight.stamp;
  publish_if_due();
}

bool OctomapBuilderNode::insert(Sensor& sensor, const std::vector<Look>& looks) {
  if (map_.insert(looks, node_.now())) return true;
  const Eigen::Vector3d p_MS = looks.back().X_MS.translation();
  give_up(sensor, kDropped,
          fmt::format("({:.0f}, {:.0f}) is farther than an OctoMap reaches", p_MS.x(), p_MS.y()));
  return false;
}

// X_MB `after` seconds after the stamp; a message without a stamp counts as taken now.
std::optional<Pose2> OctomapBuilderNode::pose_at(const Stamp& stamp, double after) {
  const auto robot = robot_.state();
  if (!robot) return std::nullopt;
  return is_zero(stamp) ? robot->X_MB : poses_.at(rt::to_seconds(stamp) + after);
}

std::optional<Pose2> OctomapBuilderNode::odometry_at(const Stamp& stamp) {
  return is_zero(stamp) ? robot_.odometry() : odometry_.at(rt::to_seconds(stamp));
}

// Why pose_at returned nullopt.
std::string OctomapBuilderNode::why_no_pose(const Stamp& stamp) {
  const auto newest = poses_.newest();
  if (!newest || !robot_.state())
    return "not localized: odom, or the transform from map to odom, is silent";
  const double ahead = rt::to_seconds(stamp) - *newest;
  return fmt::format(
      "no odometry of its time: its stamp is {:.1f} s {} odometry's; set the clock of the computer "
      "that stamps it, or restart its driver if it sends old data",
      std::abs(ahead), ahead > 0.0 ? "ahead of" : "behind");
}

std::string OctomapBuilderNode::reason() {
  if (!scanner_.watch.is_heard() && !camera_.watch.is_heard() &&
      params_->watch.required_sensors.empty())
    return "no data on scan or cloud_in: is a sensor's driver running?";
  std::string all;
  for (Sensor* sensor : {&scanner_, &camera_})
    if (const std::string why = sensor->watch.reason(node_.now()); !why.empty())
      all += (all.empty() ? "" : "; ") + why;
  return all;
}

void OctomapBuilderNode::publish_status() {
  tandem_msgs::msg::SensingStatus msg;
  msg.header(header(node_.stamp(), params_->input.frames.base));
  msg.reason(reason());
  msg.reason_code(to_msg(reason_in(msg.reason())));
  status_.publish(msg);
  diagnose(msg.reason());
}

// Sensors that have not sent anything yet may still be starting. Counts in brackets change from
// look to look and do not make a new reason.
void OctomapBuilderNode::warn_of(const std::string& reason) {
  const std::string text = "the robot must stand still: " + reason;
  if (!scanner_.watch.is_heard() && !camera_.watch.is_heard())
    return node_.log().missing_every(kReminder, "{}", text);
  node_.log().write_every(kReminder, rt::LogLevel::kError, reason.substr(0, reason.find('(')),
                          text);
}

void OctomapBuilderNode::diagnose(const std::string& reason) {
  if (!reason.empty()) {
    warn_of(reason);
    return diagnostics_.report_trouble(reason);
  }
  for (const Sensor* sensor : {&scanner_, &camera_})
    if (const std::string warning = sensor->watch.warning(); !warning.empty()) {
      node_.log().write_every(kReminder, rt::LogLevel::kWarn, sensor->topic, warning);
      return diagnostics_.report_trouble(warning);
    }
  diagnostics_.report_well(
      fmt::format("all sensors deliver valid data; returns inside the outline, dropped: {} of "
                  "scan, {} of cloud_in",
                  scanner_.own_body, camera_.own_body));
}

void OctomapBuilderNode::publish_if_due() {
  const double now = node_.now(), began = node_.steady_now();
  if (!unsent_ || began < rested_ || (now >= sent_ && now - sent_ < params_->period)) return;
  publish_status();
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
