// SPDX-License-Identifier: Apache-2.0
// The text of a script, read as the phases that the driver `script` goes through.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "tandem/driver/route.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Along a route, forward or with the rear ahead, until its end is `tolerance` away.
struct PathPhase {
  Route route;
  double direction = 1.0;       ///< −1: the rear leads
  double stick = 0.8;           ///< [1] share of the stick's way
  double end_stick = 0.15;      ///< [1] at the end of the route
  double tolerance = 0.05;      ///< [m] along the route
  bool leader_arrives = false;  ///< the phase ends when the leader is there, not the robot
};

/// On the spot until the robot looks in the direction `heading`.
struct TurnPhase {
  double heading = 0.0;     ///< in M [rad]
  double stick = 0.6;       ///< [1]
  double tolerance = 0.05;  ///< [rad]
};

/// The stick stays where it is; at rest (0, 0) the dead-man is held.
struct PushPhase {
  double linear = 0.0, angular = 0.0;  ///< [1]
};

struct ScriptPhase {
  std::variant<PushPhase, PathPhase, TurnPhase> action;
  double time = 30.0;  ///< [s] a push ends after it, path and turn are given up
};

/// Reads a script: phases separated by `;` or line ends, lengths in m, angles in rad, times in s;
/// `#` begins a comment to the end of the line.
///
///   path forward STICK [to STICK_AT_END] [within TOLERANCE] [for TIMEOUT] [leader] via X Y X Y …
///   path back …       the same with the rear ahead
///   turn HEADING [stick STICK] [within TOLERANCE] [for TIMEOUT]
///   hold TIME         the stick at rest
///   push LINEAR ANGULAR TIME
///
/// From 0.9 m to 0.1 m before the end of a path its stick falls to STICK_AT_END. `leader` ends the
/// path when the leader has come to the end, where the method has one. A coordinate is a sum of
/// numbers and of the distances from base_link to the outline's edges: `4.0-0.07-front` (also rear,
/// left, right).
///
/// A late decision is a path `to` the same stick that ends `within` some distance; a sudden reverse
/// is a push after such a path; creeping is a path of little stick.
///
/// Throws std::invalid_argument, one line that names the phase, counted from 1.
[[nodiscard]] std::vector<ScriptPhase> read_script(const std::string& script,
                                                   const Footprint& outline);

}  // namespace tandem
