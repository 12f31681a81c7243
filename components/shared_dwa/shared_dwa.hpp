// SPDX-License-Identifier: Apache-2.0
// Chooses the admissible command closest to the person's by the dynamic window approach.
#pragma once

#include "tandem/config/params.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// Sampling, weights and margins of the Shared Dynamic Window Approach.
struct SharedDwaParams {
  double control_period = 0.05;
  double window = 0.25;
  int v_samples = 11;
  int w_samples = 21;
  double horizon = 2.0;
  double margin = 0.06;
  double comfort = 0.25;
  double weight_v = 1.0;
  double weight_w = 0.4;
  double weight_way = 3.0;
  double weight_clearance = 0.3;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("control_period", control_period, Range{0.01, 1.0}, "[s] period of the choice");
    field(
        "window", window, Range{0.01, 2.0},
        "[s] samples are the speeds that can be reached by braking or accelerating for this long");
    field("v_samples", v_samples, Range{2, 101},
          "number of forward speeds sampled across the window");
    field("w_samples", w_samples, Range{2, 101}, "number of turn rates sampled across the window");
    field("horizon", horizon, Range{0.1, 10.0}, "[s] look-ahead along each arc");
    field("margin", margin, Range{0.0, 0.5},
          "[m] distance kept from obstacles until the robot has stopped");
    field("comfort", comfort, Range{0.01, 2.0}, "[m] clearance below which proximity is penalized");
    field("weight_v", weight_v, Range{0.0, 100.0}, "[1] weight of disagreement in forward speed");
    field("weight_w", weight_w, Range{0.0, 100.0}, "[1] weight of disagreement in turn rate");
    field("weight_way", weight_way, Range{0.0, 100.0}, "[1] weight of contact within the horizon");
    field("weight_clearance", weight_clearance, Range{0.0, 100.0}, "[1] weight of proximity");
  }
};

/// The chosen command and its rating.
struct DwaChoice {
  Twist2 command;          ///< zero if no sample is admissible
  bool admissible = true;  ///< false: no sample is admissible and the robot must brake
  double cost = 0.0;       ///< weighted sum; lower is better
  double clearance = 0.0;  ///< of the outline now [m], at most 1
  int looked_at = 0;       ///< number of arcs checked against the map
};

/// Shared Dynamic Window Approach: the Dynamic Window Approach (Fox, Burgard, Thrun 1997) with the
/// person's command instead of a goal. Of the admissible twists in the window around the present
/// one it chooses the one of least cost
///
///   C_v ((v − v_user) / v_max)² + C_w ((ω − ω_user) / ω_max)²
///     + C_way (1 − t_free / horizon)² + C_c max(0, 1 − c / comfort)²                          (1)
///
/// t_free: time along the arc until the margin is violated [s]; c: least clearance until rest [m].
/// A twist is admissible if the robot, after one control period at this twist and braking along its
/// arc, has kept the margin or, if it is inside the margin already, its present clearance. The
/// exact outline is checked against the map's cells.
class SharedDwa {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  SharedDwa(const SharedDwaParams& params, const RobotParams& robot);

  /// `measured`: body twist at X_MB (map frame) [m/s, rad/s]; `user`: the person's command.
  [[nodiscard]] DwaChoice choose(const Pose2& X_MB, const Twist2& measured, const Twist2& user,
                                 const StaticMap& map) const;

 private:
  struct Arc {
    double t_free = 0.0;     // [s] until the margin is violated, at most the horizon
    double clearance = 0.0;  // [m] least clearance until rest
    bool admissible = false;
  };
  struct Sample {
    Twist2 twist;
    double disagreement;  // the first two terms of (1)
  };

  [[nodiscard]] std::vector<Sample> samples(const Twist2& measured, const Twist2& user) const;
  [[nodiscard]] Arc follow(const Pose2& X_MB, const Twist2& twist, double margin,
                           const StaticMap& map) const;

  SharedDwaParams params_;
  RobotParams robot_;
  Footprint footprint_;
  double radius_;
};

}  // namespace tandem
