// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tandem/io/topics.hpp"
#include "tandem/model/frame_tree.hpp"
#include "tandem/model/urdf.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kPatience = 0.1;    // [s] of commands, which are taken at the next tick
constexpr double kLongestGap = 0.1;  // [s] between two /clock messages that leaving out may cause

Pose2 start_of(const DiffDriveSimNodeParams& params) {
  if (params.start.size() != 3)
    throw std::invalid_argument("start: expected three numbers: x, y and heading");
  return {params.start[0], params.start[1], params.start[2]};
}

std::shared_ptr<const StaticMap> world(rt::Node& node, const DiffDriveSimNodeParams& params) {
  return node.cached<const StaticMap>(key_of_world(params),
                                      [&] { return simulated_world(params); });
}

DiffDriveSim simulation(const DiffDriveSimNodeParams& params,
                        std::shared_ptr<const StaticMap> map) {
  DiffDriveSim sim{params.sim, params.robot, std::move(map), static_cast<unsigned>(params.seed)};
  sim.put(people_of(params));
  sim.reset(start_of(params), static_cast<unsigned>(params.seed));
  return sim;
}

// Time-out of the source check, which is needed even if the base never times out.
double source_timeout(const RobotParams& robot) {
  return robot.base_timeout > 0.0 ? robot.base_timeout : 0.5;
}

}  // namespace

rt::Interface DiffDriveSimNode::interface() {
  return TwistInput::interface(topics::cmd_vel) + RobotDescription::interface() +
         rt::Interface{
             .subscribes = {topics::initial_pose},
             .publishes = {topics::clock, topics::odom, topics::ground_truth, topics::tf,
                           topics::tf_static, topics::scan, topics::collision, topics::people},
             .serves = {services::reset},
             .other_input = "a map file"};
}

DiffDriveSimNode::DiffDriveSimNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      sim_{simulation(*params_, world(node, *params_))},
      source_{source_timeout(params_->robot)},
      scan_random_{static_cast<unsigned>(params_->seed)},
      clock_{node.create_publisher(topics::clock)},
      odom_{node.create_publisher(topics::odom)},
      ground_truth_{node.create_publisher(topics::ground_truth)},
      tf_{node.create_publisher(topics::tf)},
      tf_static_{node.create_publisher(topics::tf_static)},
      scan_{node.create_publisher(topics::scan)},
      collision_{node.create_publisher(topics::collision)},
      people_{node.create_publisher(topics::people)},
      cmd_vel_{node, topics::cmd_vel, params_->input,
               [this](const Twist2& twist) { on_command(twist); }} {
  cmd_vel_.set_frames(params_->frames);
  cmd_vel_.check_stamps_by([this] { return sim_.state().t; });
  cmd_vel_.may_wait(kPatience);
  subscribe();
  publish_frames();
  if (params_->publish_description)
    description_.emplace(node, urdf_of(params_->robot, params_->frames.base));
  timer_ = node.create_wall_timer(params_->step / params_->speed_factor, [this] { tick(); });
}

void DiffDriveSimNode::on_command(const Twist2& twist) {
  using enum SingleSource::Type;
  const double now = sim_.state().t;
  const bool alone =
      source_.on_command(cmd_vel_.sender(), cmd_vel_.is_stamped() ? kTwistStamped : kTwist, now);
  if (alone || !params_->single_source) return sim_.command(twist, now);
  sim_.command({}, now);
  node_.log().warn_every(
      1.0,
      "two programs publish cmd_vel, so the base stands: stop the one that is not the safety "
      "filter (`tandem doctor` names both), or set single_source: false");
}

void DiffDriveSimNode::subscribe() {
  initial_pose_ = node_.create_subscription(topics::initial_pose, [this](const auto& msg) {
    const auto frame = bare_frame(msg.header().frame_id());
    if (!frame.empty() && frame != bare_frame(params_->frames.map))
      node_.log().warn_every(1.0, "initialpose is given in frame `{}`, not `{}`: dropped", frame,
                             params_->frames.map);
    else if (const auto X_MB = from_msg(msg.pose().pose()))
      reset(*X_MB);
    else
      node_.log().warn_every(1.0, "initialpose {}: dropped",
                             fault_of(msg.pose().pose().orientation()));
  });
  reset_ = node_.create_service(services::reset, [this](const auto&, auto& response) {
    reset(start_of(*params_));
    response.success(true);
    response.message("at the start");
  });
}

void DiffDriveSimNode::reset(const Pose2& X_MB) {
  sim_.reset(X_MB, static_cast<unsigned>(params_->seed));
  scan_random_.seed(static_cast<unsigned>(params_->seed));
  ranges_.clear();  // a scan must not mix two poses
  turn_began_ = sim_.state().t;
  node_.log().info("reset to ({:.2f}, {:.2f}, {:.2f})", X_MB.x, X_MB.y, X_MB.theta);
}

void DiffDriveSimNode::tick() {
  ticks_ += 1 + left_out_;
  sim_.advance_to(static_cast<double>(ticks_) * params_->step);
  publish_clock();
  if (is_odometry_due(ticks_)) {
    publish_odometry();
    if (ground_truth_.matched() > 0) publish_ground_truth();
    if (people_.matched() > 0) publish_people();
    if (collision_.matched() > 0) publish_collision();
  }
  turn_scanner();
  leave_out_next();
}

// While nothing moves, the tick that publishes nothing but the time runs together with the next. A
// command that comes meanwhile counts from the last time published, as its sender knows no later
// one. After a late tick, skip_until() leaves out more than one; they are missed, as without it.
void DiffDriveSimNode::leave_out_next() {
  const double period = params_->step / params_->speed_factor;
  left_out_ = 0;
  if (is_heard_ || !sim_.is_at_rest() || is_odometry_due(ticks_ + 1)) return;
  if (2.0 * period > kLongestGap) return;
  left_out_ = std::min(1, timer_.skip_until(node_.steady_now() + period));
}

// Whether a period of odometry ends in this tick.
bool DiffDriveSimNode::is_odometry_due(long tick) const {
  const double beats_per_tick = params_->odom_rate * params_->step;
  const auto t = static_cast<double>(tick);
  return std::floor(t * beats_per_tick + 1e-9) > std::floor((t - 1.0) * beats_per_tick + 1e-9);
}

Stamp DiffDriveSimNode::stamp_at(double t) const { return rt::to_stamp(std::llround(t * 1e9)); }

void DiffDriveSimNode::publish_clock() {
  rosgraph_msgs::msg::Clock msg;
  msg.clock(stamp_at(sim_.state().t));
  clock_.publish(msg);
}

void DiffDriveSimNode::publish_odometry() {
  const auto& frames = params_->frames;
  const OdometryReport report = sim_.odometry();
  const auto odom_header = header(stamp_at(report.t), frames.odom);
  const auto map_header = header(stamp_at(report.t), frames.map);

  tf2_msgs::msg::TFMessage tf;
  tf.transforms().push_back(to_transform(report.X_MW, map_header, frames.odom));
  tf.transforms().push_back(to_transform(report.X_WB, odom_header, frames.base));
  tf_.publish(tf);
  odom_.publish(to_msg(Odometry{report.X_WB, report.twist}, odom_header, frames.base));
}

void DiffDriveSimNode::publish_ground_truth() {
  const auto& frames = params_->frames;
  const SimState& truth = sim_.state();
  ground_truth_.publish(to_msg(Odometry{truth.X_MB, truth.twist},
                               header(stamp_at(truth.t), frames.map), frames.base));
}

void DiffDriveSimNode::publish_frames() {
  tf2_msgs::msg::TFMessage msg;
  msg.transforms().push_back(to_transform(
      scanner_place(), header(stamp_at(0.0), params_->frames.base), params_->scan_frame));
  tf_static_.publish(msg);
}

// Takes the beams of this tick; publishes the scan after the last one and begins the next turn. A
// turn is skipped if `scan` has no subscriber when it begins.
void DiffDriveSimNode::turn_scanner() {
  const auto& [t, X_MB, twist] = sim_.state();
  const int beams = params_->scan_beams;
  const double turn = 1.0 / params_->scan_rate;  // [s]
  const double per_beam = time_per_beam();
  while (true) {
    const auto i = static_cast<int>(ranges_.size());
    if (i == 0) is_heard_ = scan_.matched() > 0;
    const double taken = turn_began_ + per_beam * i;
    if (taken > t) return;
    ranges_.push_back(
        is_heard_ ? noisy(scan_range_of(sim_, *params_, integrate(X_MB, twist, taken - t), i))
                  : 0.0F);
    if (i + 1 < beams) continue;
    if (is_heard_) publish_scan();
    ranges_.clear();
    turn_began_ += turn;
  }
}

float DiffDriveSimNode::noisy(float range) {
  if (params_->scan_noise <= 0.0 || !std::isfinite(range)) return range;
  std::normal_distribution<float> noise{0.0F, static_cast<float>(params_->scan_noise)};
  return std::max(0.0F, range + noise(scan_random_));
}

double DiffDriveSimNode::time_per_beam() const {
  return params_->scan_angle / kAllAround / (params_->scan_rate * params_->scan_beams);
}

void DiffDriveSimNode::publish_scan() {
  sensor_msgs::msg::LaserScan msg;
  msg.header(header(stamp_at(turn_began_), params_->scan_frame));
  const auto angle = [&](int i) { return beam_angle(i, params_->scan_beams, params_->scan_angle); };
  msg.angle_min(static_cast<float>(angle(0)));
  msg.angle_max(static_cast<float>(angle(params_->scan_beams - 1)));
  msg.angle_increment(static_cast<float>(angle(1) - angle(0)));
  msg.scan_time(static_cast<float>(1.0 / params_->scan_rate));
  msg.time_increment(static_cast<float>(time_per_beam()));
  msg.range_max(static_cast<float>(params_->scan_range));
  msg.ranges(ranges_);
  scan_.publish(msg);
}

void DiffDriveSimNode::publish_people() {
  people_.publish(
      to_msg(sim_.people().all(), header(stamp_at(sim_.state().t), params_->frames.map)));
}

void DiffDriveSimNode::publish_collision() {
  const ContactReport& contacts = sim_.contacts();
  tandem_msgs::msg::Collision msg;
  msg.header(header(stamp_at(sim_.state().t), params_->frames.map));
  msg.in_contact(contacts.in_contact);
  msg.count(contacts.count);
  msg.walked_into(contacts.walked_into);
  msg.point().x(contacts.p_MQ.x());
  msg.point().y(contacts.p_MQ.y());
  msg.pose(to_msg(sim_.state().X_MB));
  collision_.publish(msg);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::DiffDriveSimNode, "diff_drive_sim")
