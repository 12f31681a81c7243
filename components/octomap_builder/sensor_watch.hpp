// SPDX-License-Identifier: Apache-2.0
// Decides whether a sensor sees, and if not, why not.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/range_returns.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

struct SensorWatchParams {
  double sensor_timeout = 0.5;
  double min_valid_share = 0.05;
  std::vector<std::string> required_sensors;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("sensor_timeout", sensor_timeout, Range{0.05, 60.0},
          "[s] a sensor that has delivered data, or is required, must deliver a valid measurement "
          "within this time, or the robot stops");
    field("min_valid_share", min_valid_share, Range{0.0, 1.0},
          "[1] fraction of a scan's beams that must be usable for it to count as a valid "
          "measurement");
    field("required_sensors", required_sensors, OneOf{{"scan", "cloud_in"}},
          "sensors that must deliver valid data from the start; others are watched from their "
          "first message on");
  }
};

/// A look with the data needed to assess it.
struct WatchedLook {
  const RangeReturns& seen;        ///< without the robot's own body
  const Eigen::Isometry3d& X_BS;   ///< pose of the sensor
  std::optional<Pose2> X_WB = {};  ///< odometry when it was taken; nullopt: unknown
  double valid_share = 1.0;        ///< 1 for a cloud: an empty cloud is valid, too
};

/// How a look may be used.
enum class LookUse {
  kTake,      ///< insert it into the map
  kRepeated,  ///< the sensor is alive, but sent the same returns from another pose
  kNone,      ///< too few of its beams are usable
};

/// Monitors one sensor. It must see, not merely be alive: what counts is the time of its last
/// usable look.
///
/// A cloud without points is a look, because a filtered depth camera returns nothing for an empty
/// floor: it shows that the camera is alive, and neither marks nor clears anything. A scan needs
/// min_valid_share of its beams.
///
/// Returns that stay bitwise identical although odometry says that they should have moved by more
/// than two voxels mean a frozen sensor or slipping wheels. In both cases the robot must stop.
/// Motion along a surface does not count, because without noise a long wall looks the same
/// everywhere: 5 % of the returns must have moved across their surface, or all of them by 2 m on
/// average. A look without returns is never frozen. Times are seconds on one monotonic clock.
class SensorWatch {
 public:
  /// `topic`: of the sensor, may be named in required_sensors. `voxel`: side length of a voxel [m].
  /// Throws std::invalid_argument on parameters out of range.
  SensorWatch(std::string topic, const SensorWatchParams& params, double voxel);

  /// Call for a message that is not a usable look. `why` completes a sentence about the topic: "is
  /// refused: …", "gives no valid range: …".
  void on_trouble(std::string why, double t);

  /// Rates a look; `composition` summarizes its beams for the reason. Unless the result is kNone,
  /// call on_taken once the look is in the map, or on_trouble.
  [[nodiscard]] LookUse assess(const WatchedLook& look, const std::string& composition, double t);
  void on_taken(double t);

  /// Call after the clock jumped back to `now`: the sensor has the whole time-out for its next
  /// look.
  void on_time_jump(double now);

  /// Does not compare the next look with earlier ones.
  void forget() { repeated_.reset(); }

  /// Why the robot must stop, in one line that begins with the topic; empty if the sensor sees, or
  /// if it has never sent anything and is not required.
  [[nodiscard]] std::string reason(double now) const;

  /// A warning in one line if fewer than half of the usually usable beams are usable; else empty.
  [[nodiscard]] std::string warning() const;

  [[nodiscard]] bool is_heard() const { return seen_.has_value(); }

 private:
  // Identical returns in consecutive looks, and odometry's pose at the first of them.
  struct Repeated {
    std::uint64_t hash;
    Pose2 X_WB;
    int looks;
    double moved;   // [m] expected motion of the returns since then: mean …
    double across;  // [m] … and 95 % quantile across their surfaces
  };

  void on_message(double t);
  void compare(const WatchedLook& look);
  void watch_share(double share);
  [[nodiscard]] bool is_frozen() const;

  std::string topic_;
  SensorWatchParams params_;
  double voxel_;
  bool required_;
  std::optional<double> seen_;    // when it last saw, or sent its first message [s]
  Stamped<std::string> trouble_;  // of the last message; empty if that was a look
  std::optional<Repeated> repeated_;
  double usual_share_ = 0.0, share_ = 0.0;
  int looks_with_few_ = 0;  // in a row
};

}  // namespace tandem
