// SPDX-License-Identifier: Apache-2.0
// Parses a script into the phases that the driver `script` executes.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "tandem/driver/route.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Drives along a route, forward or with the rear ahead, until its end is `tolerance` away.
struct PathPhase {
  Route route;                  ///< in M
  double direction = 1.0;       ///< −1: the rear leads
  double stick = 0.8;           ///< [1] share of full deflection
  double end_stick = 0.15;      ///< [1] at the end of the route
  double tolerance = 0.05;      ///< [m] along the route
  bool leader_arrives = false;  ///< the phase ends when the leader is there, not the robot
};

/// Turns on the spot until the robot faces `heading`.
struct TurnPhase {
  double heading = 0.0;     ///< in M [rad]
  double stick = 0.6;       ///< [1]
  double tolerance = 0.05;  ///< [rad]
};

/// Holds the stick constant; the dead-man is held even at rest (0, 0).
struct PushPhase {
  double linear = 0.0, angular = 0.0;  ///< [1]
};

/// One phase of a script: what the person does, and until when.
struct ScriptPhase {
  std::variant<PushPhase, PathPhase, TurnPhase> action;  ///< what the person does
  double time = 30.0;  ///< [s] a push ends after this time, a path or turn is abandoned
};

/// Parses a script: phases separated by `;` or line ends, lengths in m, angles in rad, times in s;
/// `#` begins a comment to the end of the line.
///
///   path forward STICK [to STICK_AT_END] [within TOLERANCE] [for TIMEOUT] [leader] via X Y X Y …
///   path back …       the same with the rear ahead
///   turn HEADING [stick STICK] [within TOLERANCE] [for TIMEOUT]
///   hold TIME         the stick at rest
///   push LINEAR ANGULAR TIME
///
/// From 0.9 m to 0.1 m before the end of a path its stick falls to STICK_AT_END. `leader` ends the
/// path when the leader has reached the end, if the method has a leader. A coordinate is a sum of
/// numbers and of distances from base_link to the outline's edges: `4.0-0.07-front` (also rear,
/// left, right).
///
/// To model a late decision, use a path `to` the same stick that ends `within` some distance; for a
/// sudden reverse, a push after such a path; for creeping, a path with little stick.
///
/// Throws std::invalid_argument with one line that names the phase, counted from 1.
[[nodiscard]] std::vector<ScriptPhase> read_script(const std::string& script,
                                                   const Footprint& outline);

}  // namespace tandem
