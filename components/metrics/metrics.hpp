// SPDX-License-Identifier: Apache-2.0
// In: what happened at each moment of a drive. Out: its measures, one definition each; the same
// code in lockstep, over DDS, in a study and from a recording. What only some of these can tell
// says so.
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
/// Reached when position and heading are within the tolerances of the pose's, and the robot has
/// stood there for `stand`; then the time is that when it came to rest.
struct PoseGoal {
  Pose2 X_MG;
  double tolerance = 0.2;          ///< [m]
  double heading_tolerance = 4.0;  ///< [rad] more than π: any heading
  double stand = 0.0;              ///< [s] 0: reached in passing
};
/// Reached when the whole time was driven and at least this far.
struct RoamGoal {
  double time = 120.0;     ///< [s]
  double distance = 30.0;  ///< [m]
};
using Goal = std::variant<RegionGoal, PoseGoal, RoamGoal>;

/// The middle of the goal, if it is a place.
[[nodiscard]] std::optional<Eigen::Vector2d> place_of(const Goal& goal);
/// Whether the goal is a place and the robot's centre is there.
[[nodiscard]] bool is_at(const Goal& goal, const Eigen::Vector2d& p_MB);

/// Clearance is not told apart beyond this [m].
inline constexpr double kFarClearance = 1.0;

/// One moment of a drive; frame M.
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
/// The filter speaks at every command and again after half a control period of silence, and
/// arbitration repeats its commands; so over DDS the filter has more to say than in lockstep, and
/// how much more hangs on the machine. Counted are therefore not words but looks, `kFilterLook`
/// apart: as often in lockstep, over DDS and from a recording, and their share is one of time.
/// The look is as long as the beat at which persons and planners command, so that where nobody
/// repeats himself each command is looked at once.
struct DriveCounts {
  static constexpr double kFilterLook = 0.05;  ///< [s] of the drive's time

  long filter_commands = 0;       ///< looks at which the filter had a command
  long filter_interventions = 0;  ///< of these, it changed it by more than 1 mm/s or 1 mrad/s
  long filter_episodes = 0;       ///< unbroken runs of looks at changed commands
  long plans = 0;
  long plan_fallbacks = 0;      ///< plans that were not a fresh solution
  long plan_overruns = 0;       ///< solves longer than their budget
  std::vector<double> plan_ms;  ///< one per solve [ms]

  /// What the filter did with its command, said at time t [s]: counts if it is the first word since
  /// it was time to look. Not to be told where the filter has none.
  void on_filtered(double t, bool changed);

 private:
  long last_look_ = -1;
  bool was_changed_ = false;
};

/// A total that a node has counted since its own start, which may be long before the drive.
class NodeTotal {
 public:
  /// By how much it has grown since the node's last word. A total that fell is that of a node that
  /// began anew, at zero. What a first word tells of is past, unless the node has just begun.
  [[nodiscard]] long growth(std::uint64_t total, bool just_begun = false);

 private:
  std::optional<std::uint64_t> last_;
};

/// Where the time of a drive in lockstep went [s].
struct PartTimes {
  double setup = 0.0;  ///< map, obstacles, components
  double simulator = 0.0, extractor = 0.0, planner = 0.0, filter = 0.0;
  double person = 0.0;    ///< the simulated one, and teleop
  double measures = 0.0;  ///< clearance, mostly
};

struct Quantiles {
  double p50 = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;
};

/// Nearest-rank quantiles; zeros if there is no value.
[[nodiscard]] Quantiles quantiles(std::vector<double> values);

void to_json(nlohmann::json& json, const PartTimes& times);
void from_json(const nlohmann::json& json, PartTimes& times);
void to_json(nlohmann::json& json, const Quantiles& quantiles);
void from_json(const nlohmann::json& json, Quantiles& quantiles);

/// The measures of one drive; names and units as in the JSON. Empty: not defined for this drive
/// (null in the JSON). Speeds are the robot's true ones, u and r below the person's command and the
/// robot's twist in shares of the robot's limits: (v / v_max, w / w_max).
struct DriveResult {
  std::string scenario, map, method, driver;
  unsigned seed = 0;
  bool lockstep = false;
  bool reached = false;          ///< success: the goal, within the time
  double time_to_goal_s = -1.0;  ///< −1: not reached
  double simulated_s = 0.0, wall_s = 0.0;
  double cpu_s = 0.0;              ///< of the process, user and system; in lockstep
  PartTimes part_s;                ///< of the steady clock; in lockstep
  int collisions = 0;              ///< contact episodes, see ContactReport
  std::optional<int> walked_into;  ///< times that a person walked into it; in lockstep
  double min_clearance_m = 0.0;    ///< outline to the nearest obstacle that stands
  double mean_clearance_m = 0.0;   ///< mean over time of what counts `kFarClearance` at most
  double path_length_m = 0.0;      ///< of base_link's way, there and back
  /// The same person by hand and without obstacles: another drive, which only `tandem study` makes.
  /// Empty over DDS, from a recording and of `tandem scenario`.
  std::optional<double> free_time_s;
  std::optional<double> time_ratio;  ///< time_to_goal_s / free_time_s, so in a study only
  /// BARN's, where the world is one of its: success · T / clip(time, 2 T, 8 T), T the time for the
  /// reference way at 2 m/s; 0 with a collision; in a study only.
  std::optional<double> barn_score;
  std::optional<double> path_ratio;  ///< path_length_m / shortest way; reached drives to a place
  double obedience_rms = 0.0;        ///< (1): 0 is perfect obedience
  std::optional<double> agreement_direction;       ///< (2): 1 as asked for, −1 the opposite
  std::optional<double> agreement_direction_free;  ///< (2) where the clearance is `kFree` or more
  std::optional<double> agreement_magnitude;       ///< (3): 1 as fast as asked for
  double stuck_s = 0.0;                            ///< person pushes, robot stands
  double stick_travel_per_s = 0.0;                 ///< (4) [1/s]: 1 is one full deflection
  int stick_reversals = 0;  ///< turn stick from beyond 0.1 on one side to beyond 0.1 on the other
  std::optional<double> jerk_rms;             ///< [m/s³], see rms_of_second_difference
  std::optional<double> angular_jerk_rms;     ///< [rad/s³]
  std::optional<double> spectral_arc_length;  ///< of |v|, see spectral_arc_length()
  int travel_reversals = 0;                   ///< from driving forward to driving backward, or back
  /// Farthest that base_link went on after the stick came to rest, until it was moved again or the
  /// drive ended. Empty: it never came to rest.
  std::optional<double> way_to_rest_m;
  double final_position_error_m = 0.0;
  std::optional<double> final_heading_error_rad;  ///< at least 0; where the goal is a pose
  double final_clearance_m = 0.0;                 ///< `kFarClearance` at most
  DriveCounts counts;
  Quantiles plan_ms;
  long missed_deadlines = 0;          ///< plans that took longer than the control period
  std::vector<std::string> failures;  ///< what should have held and did not
};

void to_json(nlohmann::json& json, const DriveResult& result);
/// Reads back what to_json wrote; the single solve times are not in it.
void from_json(const nlohmann::json& json, DriveResult& result);

/// What the measures are relative to.
struct MetricsSetting {
  Goal goal;
  double v_max = 1.0, w_max = 1.0;           ///< the robot's limits [m/s, rad/s]
  std::optional<RegionGoal> after = {};      ///< the goal counts once p_BA was in it
  Eigen::Vector2d p_BA = {0.0, 0.0};         ///< a point of the robot [m]
  std::optional<double> shortest_path = {};  ///< from start to goal [m], see shortest_way.hpp
  double control_period = 0.05;              ///< the planner's deadline [s]
};

/// Accumulates the measures while the drive goes on. Means are over time, T the time observed:
///
///   obedience_rms        √( mean( ½ ‖u − r‖² ) )                                              (1)
///   agreement_direction  mean( u·r / (‖u‖ ‖r‖) ) while both are above `kMoves`                (2)
///   agreement_magnitude  ∫ ‖r‖ dt / ∫ ‖u‖ dt while ‖u‖ is above `kMoves`                      (3)
///   stick_travel_per_s   Σ ‖u − last u‖ / T                                                   (4)
///
/// Measures and their names follow Urdiales, Kucukyilmaz & Demiris 2018 (jerk), Ezeh 2017
/// (agreement of direction), Balasubramanian et al. 2015 (spectral arc length).
class Metrics {
 public:
  static constexpr double kMoves = 0.05;  ///< of the limits
  static constexpr double kFree = 0.5;    ///< [m]: nothing is near

  explicit Metrics(const MetricsSetting& setting) : setting_{setting} {}

  /// Samples in order of time; one that is older than the last is left out.
  void add(const DriveSample& sample);
  /// The region or pose was reached, or the time to roam is over.
  [[nodiscard]] bool finished() const { return finished_; }
  /// Fills in what was measured.
  void write(DriveResult& result) const;

 private:
  // Mean over time of what is not always defined.
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
  std::optional<double> at_rest_{};  // [s] since when it stands at its goal
  double start_ = 0.0, time_to_goal_ = -1.0;
  double path_length_ = 0.0, min_clearance_ = 1e9, stuck_ = 0.0;
  Mean clearance_, squared_difference_, direction_, direction_free_;
  double asked_ = 0.0, done_ = 0.0;  // integrals of (3) [s]
  double stick_travel_ = 0.0;
  int stick_side_ = 0, stick_reversals_ = 0;
  int travel_side_ = 0, travel_reversals_ = 0;
  std::optional<double> rolled_;       // [m] since the stick came to rest
  std::optional<double> way_to_rest_;  // [m] the most of these
  SpeedProfile v_, w_;
  DriveSample last_;
};

}  // namespace tandem
