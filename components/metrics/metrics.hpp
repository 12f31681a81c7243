// SPDX-License-Identifier: Apache-2.0
// Computes the measures of a drive from its samples, with one definition each, shared by lockstep
// drives, drives over DDS, studies and recordings. Measures that only some of these provide are
// marked.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tandem/metrics/smoothness.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Reached when the robot's centre is in the rectangle.
struct RegionGoal {
  Eigen::Vector2d low, high;  ///< corners in M [m]
};
/// Reached when position and heading have been within the tolerances and the robot has stood still
/// there for `stand`; the time to goal is when it came to rest.
struct PoseGoal {
  Pose2 X_MG;                      ///< in M
  double tolerance = 0.2;          ///< [m]
  double heading_tolerance = 4.0;  ///< [rad] above π: any heading
  double stand = 0.0;              ///< [s] 0: passing through suffices
};
/// Reached when the full time was driven and at least this distance.
struct RoamGoal {
  double time = 120.0;     ///< [s]
  double distance = 30.0;  ///< [m]
};
/// When a drive counts as finished.
using Goal = std::variant<RegionGoal, PoseGoal, RoamGoal>;

/// The goal's centre; nullopt if the goal is not a place.
[[nodiscard]] std::optional<Eigen::Vector2d> place_of(const Goal& goal);
/// Whether the goal is a place and the robot's centre is there.
[[nodiscard]] bool is_at(const Goal& goal, const Eigen::Vector2d& p_MB);

/// Larger clearances are recorded as this [m].
inline constexpr double kFarClearance = 1.0;

/// One sample of a drive, in frame M.
struct DriveSample {
  double t = 0.0;                  ///< simulated [s]
  Pose2 X_MB = {};                 ///< ground truth
  Twist2 twist = {};               ///< ground truth
  Twist2 user = {};                ///< the person's command
  double clearance = 0.0;          ///< footprint to nearest obstacle [m], `kFarClearance` at most
  int collisions = 0;              ///< contact episodes so far
  std::optional<Pose2> X_ML = {};  ///< the person's leader
};

/// What the filter and the planner did during the drive.
///
/// The filter reports at every command and again after half a control period without one, and
/// arbitration repeats its commands. Over DDS the filter therefore reports more often than in
/// lockstep, and how much more depends on the machine. The counts are therefore sampled: only
/// the first report in each interval of `kFilterLook` counts. That gives the same counts in
/// lockstep, over DDS and from a recording, and their ratio is a share of time. The interval equals
/// the command period of persons and planners, so without repetitions each command counts once.
struct DriveCounts {
  static constexpr double kFilterLook = 0.05;  ///< [s] sampling interval, in the drive's time

  long filter_commands = 0;       ///< intervals in which the filter had a command
  long filter_interventions = 0;  ///< of these: changed by more than 1 mm/s or 1 mrad/s
  long filter_episodes = 0;       ///< uninterrupted runs of such intervals
  long plans = 0;                 ///< planning cycles
  long plan_fallbacks = 0;        ///< plans that were not a fresh solution
  long plan_overruns = 0;         ///< solves longer than their budget
  std::vector<double> plan_ms;    ///< one per solve [ms]

  /// Takes a report of the filter at time t [s]; only the first one in each interval counts. Do
  /// not call if the filter had no command.
  void on_filtered(double t, bool changed);

 private:
  long last_look_ = -1;
  bool was_changed_ = false;
};

/// Turns a running total, counted since its node started, into increments.
class NodeTotal {
 public:
  /// Increase since the node's last report. A smaller total means that the node restarted at zero.
  /// The first report returns 0, because its total is from before the drive, unless the node has
  /// just started.
  [[nodiscard]] long growth(std::uint64_t total, bool just_begun = false);

 private:
  std::optional<std::uint64_t> last_;
};

/// Computing time of a lockstep drive by part [s].
struct PartTimes {
  double setup = 0.0;  ///< map, obstacles, components
  double simulator = 0.0, extractor = 0.0, planner = 0.0, filter = 0.0;  ///< [s]
  double person = 0.0;    ///< the simulated person, and teleop
  double measures = 0.0;  ///< mostly the clearance
};

/// Of a set of values, in their unit.
struct Quantiles {
  double p50 = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;  ///< percentiles 50, 95 and 99
};

/// Nearest-rank quantiles; zeros if there is no value.
[[nodiscard]] Quantiles quantiles(std::vector<double> values);

/// Writes each part under its name [s].
void to_json(nlohmann::json& json, const PartTimes& times);
/// Reads what to_json wrote; throws nlohmann::json::exception otherwise.
void from_json(const nlohmann::json& json, PartTimes& times);
/// Writes p50, p95, p99 and max.
void to_json(nlohmann::json& json, const Quantiles& quantiles);
/// Reads what to_json wrote; throws nlohmann::json::exception otherwise.
void from_json(const nlohmann::json& json, Quantiles& quantiles);

/// The measures of one drive; names and units as in the JSON. An empty optional is not defined for
/// the drive (null in the JSON). Speeds are the robot's true ones. Below, u and r are the person's
/// command and the robot's twist as shares of the robot's limits: (v / v_max, w / w_max).
struct DriveResult {
  std::string scenario, map, method, driver;  ///< names
  unsigned seed = 0;                          ///< of the simulated person
  bool lockstep = false;                      ///< false: over DDS
  bool reached = false;                       ///< success: the goal was reached within the time
  double time_to_goal_s = -1.0;               ///< −1: not reached
  double simulated_s = 0.0, wall_s = 0.0;     ///< simulated time, and how long that took [s]
  double cpu_s = 0.0;                         ///< of the process, user and system; lockstep only
  PartTimes part_s;                           ///< by the steady clock; lockstep only
  int collisions = 0;                         ///< contact episodes, see ContactReport
  std::optional<int> walked_into;             ///< times that a person walked into it
  double min_clearance_m = 0.0;               ///< outline to the nearest static obstacle
  double mean_clearance_m = 0.0;  ///< mean over time, each sample at most `kFarClearance`
  double path_length_m = 0.0;     ///< length of base_link's path, reversing included
  /// Time of the same person driving manually without obstacles. That is another drive, which only
  /// `tandem study` makes; empty over DDS, from a recording and for `tandem scenario`.
  std::optional<double> free_time_s;
  std::optional<double> time_ratio;  ///< time_to_goal_s / free_time_s; study only
  /// BARN score, for BARN worlds: success · T / clip(time, 2 T, 8 T), where T is the time for the
  /// reference path at 2 m/s; 0 with a collision; study only.
  std::optional<double> barn_score;
  std::optional<double> path_ratio;  ///< path_length_m / shortest path; if a place was reached
  double obedience_rms = 0.0;        ///< (1): 0 is perfect obedience
  std::optional<double> agreement_direction;       ///< (2): 1 as commanded, −1 the opposite
  std::optional<double> agreement_direction_free;  ///< (2) where the clearance is `kFree` or more
  std::optional<double> agreement_magnitude;       ///< (3): 1 as fast as commanded
  double stuck_s = 0.0;             ///< time that the person pushes and the robot stands still
  double stick_travel_per_s = 0.0;  ///< (4) [1/s]: 1 is one full deflection
  int stick_reversals = 0;         ///< turns from beyond 0.1 on one side to beyond 0.1 on the other
  std::optional<double> jerk_rms;  ///< [m/s³], see rms_of_second_difference
  std::optional<double> angular_jerk_rms;     ///< [rad/s³]
  std::optional<double> spectral_arc_length;  ///< of |v|, see spectral_arc_length()
  int travel_reversals = 0;                   ///< changes between driving forward and backward
  /// Longest distance that base_link moved after the stick came to rest, until it was moved again
  /// or the drive ended. Empty: it never came to rest.
  std::optional<double> way_to_rest_m;
  double final_position_error_m = 0.0;            ///< of the centre, to the goal
  std::optional<double> final_heading_error_rad;  ///< at least 0; only if the goal is a pose
  double final_clearance_m = 0.0;                 ///< `kFarClearance` at most
  DriveCounts counts;                             ///< of the filter and the planner
  Quantiles plan_ms;                              ///< time of a planning cycle [ms]
  long missed_deadlines = 0;                      ///< plans slower than the control period
  std::vector<std::string> failures;              ///< expectations that were not met
};

/// Writes every field under its name; an optional one without a value as null.
void to_json(nlohmann::json& json, const DriveResult& result);
/// Reads what to_json wrote; the individual solve times are not included.
void from_json(const nlohmann::json& json, DriveResult& result);

/// Reference values of the measures.
struct MetricsSetting {
  Goal goal;                                 ///< what ends the drive
  double v_max = 1.0, w_max = 1.0;           ///< the robot's limits [m/s, rad/s]
  std::optional<RegionGoal> after = {};      ///< the goal counts only after p_BA was in it
  Eigen::Vector2d p_BA = {0.0, 0.0};         ///< a point of the robot [m]
  std::optional<double> shortest_path = {};  ///< from start to goal [m], see shortest_path.hpp
  double control_period = 0.05;              ///< the planner's deadline [s]
};

/// Accumulates the measures during the drive. Means are over time; T is the observed time:
///
///   obedience_rms        √( mean( ½ ‖u − r‖² ) )                                              (1)
///   agreement_direction  mean( u·r / (‖u‖ ‖r‖) ) while both are above `kMoves`                (2)
///   agreement_magnitude  ∫ ‖r‖ dt / ∫ ‖u‖ dt while ‖u‖ is above `kMoves`                      (3)
///   stick_travel_per_s   Σ ‖u − last u‖ / T                                                   (4)
///
/// Measures and their names follow Urdiales, Kucukyilmaz & Demiris 2018 (jerk), Ezeh 2017
/// (agreement of direction) and Balasubramanian et al. 2015 (spectral arc length).
class Metrics {
 public:
  static constexpr double kMoves = 0.05;  ///< of the limits
  static constexpr double kFree = 0.5;    ///< [m]: nothing is near

  /// Begins a drive.
  explicit Metrics(const MetricsSetting& setting) : setting_{setting} {}

  /// Samples must be in time order; one older than the last is ignored.
  void add(const DriveSample& sample);
  /// Whether the region or pose was reached, or the time to roam is over.
  [[nodiscard]] bool finished() const { return finished_; }
  /// Writes the measures into `result`.
  void write(DriveResult& result) const;

 private:
  // Mean over time of a value that is not always defined.
  struct Mean {
    double sum = 0.0, time = 0.0;
    void add(double value, double dt) { sum += value * dt, time += dt; }
    [[nodiscard]] std::optional<double> value() const {
      return time > 0.0 ? std::optional{sum / time} : std::nullopt;
    }
  };

  [[nodiscard]] bool is_finished(const DriveSample& sample);
  [[nodiscard]] Eigen::Vector2d in_limits(const Twist2& twist) const;
  void compare(const DriveSample& sample, double dt);
  void watch_stick(const DriveSample& sample);
  void watch_travel(const DriveSample& sample);

  MetricsSetting setting_;
  bool started_ = false, finished_ = false;
  bool was_after_ = false;           // p_BA was in setting_.after
  std::optional<double> at_rest_{};  // [s] since when the robot stands at its goal
  double start_ = 0.0, time_to_goal_ = -1.0;
  double path_length_ = 0.0, min_clearance_ = 1e9, stuck_ = 0.0;
  Mean clearance_, squared_difference_, direction_, direction_free_;
  double asked_ = 0.0, done_ = 0.0;  // integrals of (3) [s]
  double stick_travel_ = 0.0;
  int stick_side_ = 0, stick_reversals_ = 0;
  int travel_side_ = 0, travel_reversals_ = 0;
  std::optional<double> rolled_;       // [m] distance since the stick came to rest
  std::optional<double> way_to_rest_;  // [m] maximum of these
  SpeedProfile v_, w_;
  DriveSample last_;
};

}  // namespace tandem
