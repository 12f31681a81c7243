// SPDX-License-Identifier: Apache-2.0
// In: what happened at each moment of a drive. Out: its measures, one definition each; the same
// code for lockstep and for DDS.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "model/obstacle.hpp"
#include "model/se2.hpp"

namespace tandem {

/// Reached when the robot's centre is in the rectangle.
struct RegionGoal {
  Eigen::Vector2d low, high;  ///< corners in M [m]
};
/// Reached when the distance to the pose's position is at most the tolerance.
struct PoseGoal {
  Pose2 X_MG;
  double tolerance = 0.2;  ///< [m]
};
/// Reached when the whole time was driven and at least this far.
struct RoamGoal {
  double time = 120.0;     ///< [s]
  double distance = 30.0;  ///< [m]
};
using Goal = std::variant<RegionGoal, PoseGoal, RoamGoal>;

/// One moment of a drive; frame M.
struct DriveSample {
  double t = 0.0;             ///< simulated [s]
  Pose2 X_MB;                 ///< ground truth
  Twist2 twist;               ///< ground truth
  Twist2 user;                ///< the person's command
  double clearance = 0.0;     ///< footprint to nearest obstacle [m]
  int collisions = 0;         ///< contact episodes so far
  std::optional<Pose2> X_ML;  ///< the person's leader
};

/// What the filter and the planner did, counted by whoever sees their commands.
struct DriveCounts {
  long filter_commands = 0;       ///< commands that reached the filter
  long filter_interventions = 0;  ///< of these, changed by more than 1 mm/s or 1 mrad/s
  long plans = 0;
  long plan_fallbacks = 0;      ///< plans that were not a fresh solution
  long plan_overruns = 0;       ///< solves longer than their budget
  std::vector<double> plan_ms;  ///< one per solve [ms]
};

struct Quantiles {
  double p50 = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;
};

/// Nearest-rank quantiles; zeros if there is no value.
[[nodiscard]] Quantiles quantiles(std::vector<double> values);

/// The measures of one drive; names and units as in the JSON.
struct DriveResult {
  std::string scenario, map, method, driver;
  unsigned seed = 0;
  bool lockstep = false;
  bool reached = false;
  double time_to_goal_s = -1.0;  ///< −1: not reached
  double simulated_s = 0.0, wall_s = 0.0;
  int collisions = 0;
  double min_clearance_m = 0.0;
  double path_length_m = 0.0;
  double obedience_rms = 0.0;  ///< (1): 0 is perfect obedience
  double stuck_s = 0.0;        ///< person pushes, robot stands
  double final_position_error_m = 0.0;
  DriveCounts counts;
  Quantiles plan_ms;
  std::vector<std::string> failures;  ///< what should have held and did not
};

void to_json(nlohmann::json& json, const DriveResult& result);
/// Reads back what to_json wrote; the single solve times are not in it.
void from_json(const nlohmann::json& json, DriveResult& result);

/// Accumulates the measures while the drive goes on.
///
///   obedience_rms = √( mean( ½ ((v_user − v) / v_max)² + ½ ((w_user − w) / w_max)² ) )   (1)
class Metrics {
 public:
  Metrics(Goal goal, double v_max, double w_max) : goal_{goal}, v_max_{v_max}, w_max_{w_max} {}

  void add(const DriveSample& sample);
  /// The region or pose was reached, or the time to roam is over.
  [[nodiscard]] bool finished() const { return finished_; }
  /// Fills in what was measured.
  void write(DriveResult& result) const;

 private:
  [[nodiscard]] bool is_finished(const DriveSample& sample) const;

  Goal goal_;
  double v_max_, w_max_;
  bool started_ = false, finished_ = false;
  double start_ = 0.0, time_to_goal_ = -1.0;
  double path_length_ = 0.0, min_clearance_ = 1e9, stuck_ = 0.0;
  double squared_difference_ = 0.0, observed_ = 0.0;
  DriveSample last_;
};

}  // namespace tandem
