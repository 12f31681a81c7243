// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/diff_drive_sim.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace tandem {
namespace {

constexpr double kClearanceCap = 1.0;  // [m] larger clearances are reported as this
constexpr double kLookAhead = 0.1;     // [m] measured beyond what is needed, to save later calls
constexpr double kContactPrecision = 1e-4;  // [m] maximum gap to what stopped the robot
constexpr double kTimePrecision = 1e-9;     // [s]
constexpr double kEpisodeClearance = 0.05;  // [m] a contact ends above this clearance …
constexpr double kEpisodeTime = 0.5;        // [s] … held for this long
constexpr double kStandingSpeed = 0.05;     // [m/s] of the fastest point of a robot that stands

}  // namespace

DiffDriveSim::DiffDriveSim(const DiffDriveSimParams& params, const RobotParams& robot,
                           std::shared_ptr<const StaticMap> map, unsigned seed)
    : params_{params},
      robot_{robot},
      map_{std::move(map)},
      footprint_{footprint_of(robot)},
      radius_{circumradius(footprint_)},
      drive_{params.drive, robot, seed} {
  check(params);
  if (!map_) throw std::invalid_argument("diff_drive_sim: no map");
  reset({}, seed);
}

void DiffDriveSim::reset(const Pose2& X_MB, unsigned seed) {
  drive_ = Drive{params_.drive, robot_, seed};
  std::mt19937 random{seed + 1};
  std::uniform_real_distribution<double> scale(1.0 - params_.odometry_noise,
                                               1.0 + params_.odometry_noise);
  odometry_scale_.left = scale(random);
  odometry_scale_.right = scale(random);
  state_ = {state_.t, X_MB, {}};
  X_WB_ = {};
  samples_.clear();
  people_.restart();
  contacts_ = {};
  clearance_bound_ = map_->clearance(footprint_, X_MB, kClearanceCap);
  min_clearance_ = clearance_bound_;
  if (clearance_bound_ <= 0.0) touch(X_MB);
  record();
}

void DiffDriveSim::advance_to(double t) {
  while (t - state_.t > kTimePrecision) step(std::min(params_.max_step, t - state_.t));
}

void DiffDriveSim::step(double dt) {
  drive_.step(state_.t, dt);
  const Pose2 before = state_.X_MB;
  state_.X_MB = move(dt);
  state_.t += dt;
  state_.twist = drive_.twist_over_ground();
  const double travel = std::hypot(state_.X_MB.x - before.x, state_.X_MB.y - before.y) +
                        radius_ * std::abs(state_.X_MB.theta - before.theta);
  update_clearance(travel);
  people_.advance(dt);
  meet_people();
  record();
}

// The pose after dt, or the last contact-free pose on the way to it.
Pose2 DiffDriveSim::move(double dt) {
  const Pose2 start = state_.X_MB;
  const Twist2 twist = drive_.twist_over_ground();
  const double speed = std::abs(twist.v) + radius_ * std::abs(twist.w);
  const WheelSpeeds& rims = drive_.speeds();
  const Twist2 seen =
      to_body({odometry_scale_.left * rims.left, odometry_scale_.right * rims.right},
              robot_.wheel_separation);
  const auto free = [&](double time) { return !touches(integrate(start, twist, time)); };

  double time = dt;
  if (speed * dt >= clearance_bound_ && !free(dt) && free(0.0)) {
    double blocked = dt;
    time = 0.0;
    while ((blocked - time) * speed > kContactPrecision) {
      const double middle = 0.5 * (time + blocked);
      (free(middle) ? time : blocked) = middle;
    }
    touch(integrate(start, twist, blocked));
    drive_.stall();
  }
  X_WB_ = integrate(X_WB_, seen, time);
  return integrate(start, twist, time);
}

bool DiffDriveSim::touches(const Pose2& X_MB) const {
  return map_->clearance(footprint_, X_MB, kContactPrecision) <= 0.0;
}

void DiffDriveSim::touch(const Pose2& X_MB) {
  clear_since_ = state_.t;
  if (contacts_.in_contact && counted_) return;
  if (!contacts_.in_contact) open_episode(X_MB.position());
  counted_ = true;
  ++contacts_.count;
  double nearest = std::numeric_limits<double>::infinity();
  const double side = map_->grid().resolution;
  for (const auto& p_MC : map_->cells_near(X_MB.position(), radius_ + side)) {
    const double d = distance_to_square(footprint_, X_MB, p_MC, side);
    if (d >= nearest) continue;
    nearest = d;
    contacts_.p_MQ = p_MC;
  }
}

void DiffDriveSim::open_episode(const Eigen::Vector2d& p_MQ) {
  contacts_.in_contact = true;
  contacts_.p_MQ = p_MQ;
  counted_ = false;
}

void DiffDriveSim::meet_people() {
  const double fastest = std::abs(state_.twist.v) + radius_ * std::abs(state_.twist.w);
  for (const Obstacle& person : people_.all()) {
    const double away = (person.p_MO - state_.X_MB.position()).norm() - radius_ - person.a;
    if (away > kEpisodeClearance) continue;
    const double gap =
        distance(footprint_, transform(inverse(state_.X_MB), person.p_MO)) - person.a;
    if (contacts_.in_contact && gap < kEpisodeClearance) clear_since_ = state_.t;
    if (gap > 0.0) continue;
    const bool moves = fastest > kStandingSpeed;
    if (!contacts_.in_contact) {
      open_episode(person.p_MO);
      clear_since_ = state_.t;
      if (!moves) ++contacts_.walked_into;
    }
    if (moves && !counted_) ++contacts_.count;
    counted_ = counted_ || moves;
  }
}

// Measures only if the clearance may have fallen below the value of interest.
void DiffDriveSim::update_clearance(double travel) {
  const double matters =
      contacts_.in_contact ? std::max(min_clearance_, kEpisodeClearance) : min_clearance_;
  clearance_bound_ =
      std::max({0.0, clearance_bound_ - travel, map_->distance(state_.X_MB.position()) - radius_});
  if (clearance_bound_ < matters) {
    clearance_bound_ = map_->clearance(footprint_, state_.X_MB, matters + kLookAhead);
    min_clearance_ = std::min(min_clearance_, clearance_bound_);
  }
  if (!contacts_.in_contact) return;
  if (clearance_bound_ < kEpisodeClearance) clear_since_ = state_.t;
  if (state_.t - clear_since_ >= kEpisodeTime) contacts_.in_contact = false;
}

void DiffDriveSim::record() {
  const WheelSpeeds& rims = drive_.speeds();
  samples_.push_back(
      {state_.t, X_WB_, state_.X_MB,
       to_body({odometry_scale_.left * rims.left, odometry_scale_.right * rims.right},
               robot_.wheel_separation)});
  const double delay = params_.sensor_delay_fraction * robot_.sensor_delay;
  while (samples_.size() > 1 && samples_[1].t <= state_.t - delay + kTimePrecision)
    samples_.pop_front();
}

OdometryReport DiffDriveSim::odometry() const {
  const Sample& sample = samples_.front();
  Pose2 X_MW = compose(sample.X_MB, inverse(sample.X_WB));
  return {sample.t, sample.X_WB, sample.twist, X_MW};
}

double DiffDriveSim::beam(const Pose2& X_MB, int i, int beams, double max_range,
                          double scan_angle) const {
  const double angle = beam_angle(i, beams, scan_angle);
  const double wall = map_->cast_ray(X_MB.position(), X_MB.theta + angle, max_range);
  return people_.cast_ray(X_MB.position(), X_MB.theta + angle, wall);
}

}  // namespace tandem
