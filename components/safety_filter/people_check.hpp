// SPDX-License-Identifier: Apache-2.0
// Checks that a motion cannot touch a tracked person while the robot moves.
#pragma once

#include <span>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/robot.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/safety_filter/clearance_check.hpp"
#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

/// Bounds on people's motion and on the errors of their tracks.
struct PeopleParams {
  bool watched = false;
  double people_timeout = 0.2;
  double people_delay = 0.05;
  double person_error = 0.02;
  double person_speed_error = 0.1;
  double person_speed = 1.6;
  double person_acceleration = 1.5;
  double creep_speed = 0.04;

  template <class Visitor>
  void visit(Visitor&& field) {
    field(
        "people", watched,
        "true: subscribes to `people`, keeps away from them, and stops while that topic is silent");
    field("people_timeout", people_timeout, Range{0.02, 5.0},
          "[s] the robot stops when people has been silent for this long, if it is used");
    field("people_delay", people_delay, Range{0.0, 1.0},
          "[s] upper bound on the age of a list of people on arrival");
    field("person_error", person_error, Range{0.0, 1.0},
          "[m] upper bound on a person's position error");
    field("person_speed_error", person_speed_error, Range{0.0, 2.0},
          "[m/s] upper bound on a person's velocity error");
    field("person_speed", person_speed, Range{0.0, 5.0}, "[m/s] upper bound on a person's speed");
    field("person_acceleration", person_acceleration, Range{0.0, 20.0},
          "[m/s²] upper bound on a person's acceleration");
    field("creep_speed", creep_speed, Range{0.0, 0.3},
          "[m/s] a robot whose fastest point moves no faster counts as standing");
  }
};

/// The last list of people, with its arrival. Each counts as the smallest circle around it.
using PeopleSeen = Stamped<std::vector<Obstacle>>;

/// Keeps motions away from where people may be: passive safety, no contact while the robot moves.
///
/// A person of radius r, reported at p with velocity v by a list that arrived τ ago and was at most
/// D old on arrival, lies in both of the discs
///
///   centre p + v (τ + D/2)   radius r + e + |v| D/2 + e_v (τ + D) + ½ a (τ + D)²              (1)
///   centre p                 radius r + e + max(s, |v| + e_v) (τ + D)
///
/// with e, e_v the errors, s and a the bounds on speed and acceleration. A motion that creeps from
/// start to end may continue beside a person, as long as the gap to the person's predicted current
/// position does not drop below the margin or, if smaller, its initial value.
class PeopleCheck {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  PeopleCheck(const PeopleParams& params, const RobotParams& robot, const BoundedFootprint& body);

  /// Whether everybody is so far away that no such motion needs a detailed check. `way` bounds the
  /// travel of any point of the outline, margin and deviation included [m]; `duration` is the
  /// longest time until the robot stands [s].
  [[nodiscard]] bool is_far(const PeopleSeen& people, const Pose2& X_MB, double way, double t_start,
                            double duration) const;

  /// Whether all motions of the cell, which start at X_MB at time t_start with the measured twist,
  /// stay at least `level` [m] plus their deviation away from all people until the robot stands.
  [[nodiscard]] bool keeps_away(const StoppingEnvelope& envelope, const ShareCell& cell,
                                const Twist2& measured, const Pose2& X_MB, double t_start,
                                const PeopleSeen& people, double level,
                                const DriftBounds& drift) const;

  /// Time after the end of the envelope during which the robot may still be faster than creep_speed
  /// [s].
  [[nodiscard]] double tail() const { return tail_; }

 private:
  struct Discs;
  struct Look;
  [[nodiscard]] double fastest_point(const Twist2& twist) const;
  [[nodiscard]] bool creeps(const Look& look, const Twist2& measured) const;
  [[nodiscard]] Discs discs(const Obstacle& person, double tau) const;
  [[nodiscard]] double gap(const Pose2& X_MB, const Discs& discs) const;
  // The part of the envelope in which some point may be faster than creep_speed.
  [[nodiscard]] std::span<const TwistRange> until_standing(const StoppingEnvelope& envelope) const;
  [[nodiscard]] double spreading(const Obstacle& person, double tau) const;
  [[nodiscard]] bool keeps_away(const Look& look, const Obstacle& person) const;
  [[nodiscard]] bool does_not_near(const Look& look, const Obstacle& person) const;

  PeopleParams params_;
  BoundedFootprint body_;
  double tail_;
};

}  // namespace tandem
