// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/sensor_watch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "tandem/model/frame_tree.hpp"

namespace tandem {
namespace {

constexpr double kFrozen = 2.0;   // voxels of motion across surfaces that prove a frozen sensor …
constexpr double kFar = 2.0;      // [m] … or of mean motion in any direction
constexpr double kAcross = 0.95;  // quantile of the returns
constexpr double kSuspect = 0.1;  // voxels moved; from here identical returns are not inserted
constexpr int kFrozenLooks = 3;   // a look with few returns may repeat by chance
constexpr int kLostLooks = 10;    // consecutive looks with few beams before a warning
constexpr double kLostShare = 0.5;
constexpr double kForget = 0.999;  // decay of the usual share per look

// FNV-1a hash over all bits, word by word.
std::uint64_t hash_of(const std::vector<Eigen::Vector3d>& points) {
  std::uint64_t hash = 14695981039346656037U;
  for (const Eigen::Vector3d& p : points)
    for (const double x : {p.x(), p.y(), p.z()})
      hash = std::rotl((hash ^ std::bit_cast<std::uint64_t>(x)) * 1099511628211U, 29);
  return hash;
}

struct Motion {
  double mean, across;  // [m]
};

// How the returns move in the sensor's frame if the robot moves by X_BN. The line through a
// return's neighbours approximates the surface that it lies on.
Motion motion_of(const WatchedLook& look, const Pose2& X_BN) {
  const Eigen::Isometry3d X_NS = look.X_BS.inverse() * in_space(inverse(X_BN)) * look.X_BS;
  const auto& p_SQ = look.seen.p_SQ;
  const std::size_t last = p_SQ.size() - 1;
  std::vector<double> across;
  double sum = 0.0;
  for (std::size_t i = 0; i <= last; ++i) {
    const Eigen::Vector3d way = X_NS * p_SQ[i] - p_SQ[i];
    const Eigen::Vector3d along = p_SQ[std::min(i + 1, last)] - p_SQ[i == 0 ? 0 : i - 1];
    const double length = along.norm();
    across.push_back(length > 0.0 ? way.cross(along).norm() / length : way.norm());
    sum += way.norm();
  }
  const auto rank =
      across.begin() + static_cast<std::ptrdiff_t>(kAcross * static_cast<double>(last));
  std::nth_element(across.begin(), rank, across.end());
  return {sum / static_cast<double>(p_SQ.size()), *rank};
}

std::string percent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

}  // namespace

SensorWatch::SensorWatch(std::string topic, const SensorWatchParams& params, double voxel)
    : topic_{std::move(topic)}, params_{params}, voxel_{voxel} {
  check(params);
  const auto& required = params.required_sensors;
  required_ = std::find(required.begin(), required.end(), topic_) != required.end();
}

void SensorWatch::on_message(double t) {
  if (!seen_) seen_ = t;
  trouble_.t = t;
}

void SensorWatch::on_trouble(std::string why, double t) {
  on_message(t);
  trouble_.value = std::move(why);
}

LookUse SensorWatch::assess(const WatchedLook& look, const std::string& composition, double t) {
  if (!(look.valid_share > 0.0 && look.valid_share >= params_.min_valid_share)) {
    on_trouble("gives no valid range (" + composition +
                   "): is it covered or broken? If these values mean that nothing is in range, add "
                   "them to no_return",
               t);
    return LookUse::kNone;
  }
  on_message(t);
  watch_share(look.valid_share);
  compare(look);
  const bool is_repeated = repeated_ && repeated_->moved > kSuspect * voxel_;
  return is_repeated ? LookUse::kRepeated : LookUse::kTake;
}

void SensorWatch::on_taken(double t) {
  seen_ = t;
  trouble_.value.clear();
}

// Checks whether the returns repeat. Without odometry at their time the expected motion is unknown.
void SensorWatch::compare(const WatchedLook& look) {
  if (look.seen.p_SQ.empty()) return repeated_.reset();
  const std::uint64_t hash = hash_of(look.seen.p_SQ);
  if (!repeated_ || repeated_->hash != hash) {
    repeated_.reset();
    if (look.X_WB) repeated_ = Repeated{hash, *look.X_WB, 1, 0.0, 0.0};
    return;
  }
  ++repeated_->looks;
  if (!look.X_WB) return;
  const Motion motion = motion_of(look, compose(inverse(repeated_->X_WB), *look.X_WB));
  repeated_->moved = motion.mean;
  repeated_->across = motion.across;
}

bool SensorWatch::is_frozen() const {
  return repeated_ && repeated_->looks >= kFrozenLooks &&
         (repeated_->across > kFrozen * voxel_ || repeated_->moved > kFar);
}

void SensorWatch::watch_share(double share) {
  share_ = share;
  usual_share_ = std::max(share, kForget * usual_share_);
  looks_with_few_ = share < kLostShare * usual_share_ ? looks_with_few_ + 1 : 0;
}

std::string SensorWatch::reason(double now) const {
  if (!seen_)
    return required_ ? topic_ + " is silent, and required_sensors names it: is its driver running?"
                     : std::string{};
  if (is_frozen())
    return topic_ +
           " is frozen: its measurements are identical although odometry moved; restart its driver "
           "(if the wheels slip, free the robot and call octomap_builder's ~/reset)";
  if (now - *seen_ <= params_.sensor_timeout) return {};
  if (!trouble_.fresh(now, params_.sensor_timeout) || trouble_.value.empty())
    return topic_ +
           " is silent: is its driver running? (sensor_timeout; if the sensor was taken off, "
           "restart octomap_builder)";
  return topic_ + " " + trouble_.value;
}

std::string SensorWatch::warning() const {
  if (looks_with_few_ < kLostLooks) return {};
  return topic_ + ": only " + percent(share_) + " of its beams are usable, of " +
         percent(usual_share_) + " before: is it dirty, or partly covered?";
}

void SensorWatch::on_time_jump(double now) {
  if (seen_) seen_ = trouble_.t = now;
  repeated_.reset();
}

}  // namespace tandem
