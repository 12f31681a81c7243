// SPDX-License-Identifier: Apache-2.0
// In: when a sensor was heard, and what it saw. Out: whether it sees at all, and if not, why not.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/map/range_returns.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

struct SensorWatchParams {
  double sensor_timeout = 0.5;
  double min_valid_share = 0.05;
  std::vector<std::string> required_sensors;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("sensor_timeout", sensor_timeout, Range{0.05, 60.0},
          "[s] a sensor that was heard, or is required, must give a look within this time, else "
          "the robot stands");
    field("min_valid_share", min_valid_share, Range{0.0, 1.0},
          "[1] share of a scan's beams that must be usable, else it is no look");
    field("required_sensors", required_sensors, OneOf{{"scan", "cloud_in"}},
          "must give looks from the start; others only once they have been heard");
  }
};

/// A look as it is judged.
struct JudgedLook {
  const RangeReturns& seen;        ///< without the robot's own body
  const Eigen::Isometry3d& X_BS;   ///< of the sensor
  std::optional<Pose2> X_WB = {};  ///< odometry's, when it was taken; nothing: not known
  double valid_share = 1.0;        ///< 1 for a cloud: an empty one is a look, too
};

/// What a look is good for.
enum class LookUse {
  kTake,      ///< into the map
  kRepeated,  ///< the sensor is alive, but these echoes came before, from where the robot was then
  kNone,      ///< too few of its beams are usable
};

/// Judges one sensor. Alive is not seeing: what counts is when it last gave a look.
///
/// A cloud without points is a look, because a depth camera that is filtered has nothing to say of
/// an empty floor: it shows that the camera is alive, and neither marks nor clears anything. A scan
/// needs min_valid_share of its beams.
///
/// RangeReturns that are the same to the bit, look after look, though odometry says that they
/// should have moved by more than two voxels, are those of a frozen sensor or of a robot whose
/// wheels slip. Either way the robot must stand. Motion along a surface does not count, for without
/// noise a long wall looks the same all along; 5 % of the echoes must have moved across their
/// surface, or all of them by 2 m. A look without echoes is never frozen. Times are seconds on one
/// clock; one that is set back makes all new.
class SensorWatch {
 public:
  /// Of the sensor on `topic`, which required_sensors may name. `voxel`: side of one [m]. Throws
  /// std::invalid_argument on parameters out of range.
  SensorWatch(std::string topic, const SensorWatchParams& params, double voxel);

  /// A message came that is no look, for this reason: "is refused: …", "gives no valid range: …".
  void on_trouble(std::string why, double t);

  /// A look came; `composition` says what its beams are, for the reason. Unless it is of no use,
  /// say on_taken once it is in the map, or on_trouble.
  [[nodiscard]] LookUse judge(const JudgedLook& look, const std::string& composition, double t);
  void on_taken(double t);

  /// Judges the next look by itself.
  void forget() { repeated_.reset(); }

  /// Why the robot must stand, in one line that begins with the topic; empty if the sensor sees, or
  /// was never heard and need not be.
  [[nodiscard]] std::string reason(double now);

  /// What is worth a warning, in one line; empty if nothing is: fewer than half of the beams are
  /// usable that used to be.
  [[nodiscard]] std::string warning() const;

  [[nodiscard]] bool is_heard() const { return heard_since_.has_value(); }

 private:
  static constexpr double kNever = -std::numeric_limits<double>::infinity();

  // RangeReturns that came again and again, and where odometry was when they came first.
  struct Repeated {
    std::uint64_t hash;
    Pose2 X_WB;
    int looks;
    double moved;   // [m] by which the echoes should have moved meanwhile, on average …
    double across;  // [m] … and across their surfaces, 5 % of them
  };

  void on_message(double t);
  void watch_clock(double t);
  void compare(const JudgedLook& look);
  void watch_share(double share);
  [[nodiscard]] bool is_frozen() const;

  std::string topic_;
  SensorWatchParams params_;
  double voxel_;
  bool required_;
  std::optional<double> heard_since_;  // [s]
  double heard_ = kNever, looked_ = kNever, newest_ = kNever;
  std::string trouble_;  // of the last message; empty if it was a look
  std::optional<Repeated> repeated_;
  double usual_share_ = 0.0, share_ = 0.0;
  int looks_with_few_ = 0;  // in a row
};

}  // namespace tandem
