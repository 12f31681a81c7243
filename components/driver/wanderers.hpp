// SPDX-License-Identifier: Apache-2.0
// Drivers without a route: straight to the goal, at random, into the nearest obstacle, or as
// recorded.
#pragma once

#include <memory>
#include <vector>

#include "tandem/driver/navigator.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Aims straight at the goal and sees no obstacles: a Navigator whose route is only the end point
/// or, if it loops, one leg per point. After each failure aims beside the straight line for a
/// while.
class Pointer {
 public:
  /// Equal seeds give equal noise of hand and eye.
  Pointer(const NavigatorParams& params, unsigned seed);

  /// The hand at time t [s], with the robot at X_MB, seen by the person at X_MS.
  [[nodiscard]] Hand steer(const Pose2& X_MB, const Pose2& X_MS, double t);
  /// Whether the last point is reached; never if the route loops.
  [[nodiscard]] bool arrived() const { return !loop_ && legs_.front().arrived(); }

 private:
  std::vector<Navigator> legs_;  // one per goal
  std::size_t leg_ = 0;
  bool loop_;
};

/// Drives at full speed toward a random bearing, drawn again every few seconds, until `time` is
/// over.
class Reckless {
 public:
  /// Drives for `time` [s].
  Reckless(double time, unsigned seed) : time_{time}, random_{seed} {}

  /// The hand at time t [s], with the robot seen at X_MS.
  [[nodiscard]] Hand steer(const Pose2& X_MS, double t);
  /// Whether the time is over.
  [[nodiscard]] bool arrived() const { return arrived_; }

 private:
  double time_;
  std::mt19937 random_;
  double start_ = 0.0, until_ = -1.0;  // [s] start of the drive, end of the bearing
  double bearing_ = 0.0;               // in M [rad]
  bool started_ = false, arrived_ = false;
};

/// Drives at full speed at the nearest obstacle; when blocked, takes a run-up from elsewhere.
class Adversary {
 public:
  /// Equal seeds give equal run-ups.
  explicit Adversary(unsigned seed) : random_{seed} {}

  /// `map` may be null; the adversary then drives straight ahead.
  [[nodiscard]] Hand steer(const Pose2& X_MB, const Pose2& X_MS, const StaticMap* map, double t);

 private:
  std::mt19937 random_;
  Stamped<Pose2> moved_;        // where and when the robot last moved
  double run_up_until_ = -1.0;  // [s]
  double bearing_ = 0.0;        // of the run-up, in M [rad]
};

/// A recorded stick; each sample holds until the next.
struct Recording {
  std::vector<double> t;                ///< [s], not decreasing
  std::vector<double> linear, angular;  ///< [1], one for each time
};

/// Plays a recording, starting at the first call; releases the dead-man at its end.
class Replay {
 public:
  /// Throws std::invalid_argument if the three lists are empty or differ in length, or if the times
  /// decrease.
  explicit Replay(Recording recording);

  /// The recorded hand at time t [s].
  [[nodiscard]] Hand steer(double t);
  /// Whether the recording has ended.
  [[nodiscard]] bool arrived() const { return arrived_; }

 private:
  Recording recording_;
  double start_ = 0.0;
  bool started_ = false, arrived_ = false;
};

}  // namespace tandem
