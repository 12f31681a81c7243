// SPDX-License-Identifier: Apache-2.0
// Simulates a person who drives: computes joystick samples from the robot's pose, for many kinds of
// drivers.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "tandem/driver/hand.hpp"
#include "tandem/driver/navigator.hpp"
#include "tandem/driver/script.hpp"
#include "tandem/driver/wanderers.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// Which simulated person drives, with which skill.
struct DriverParams {
  std::string driver = "navigator";
  NavigatorParams navigator{};  ///< of navigator and pointer
  HandParams hand{};            ///< of the modifiers
  double reckless_time = 120.0;
  std::string script;
  RobotParams robot{};  ///< the robot that is steered
  std::vector<double> replay_t, replay_linear, replay_angular;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("driver", driver,
          "navigator, pointer, script, reckless, adversary or replay, followed by modifiers: "
          "navigator+tremor+dropouts");
    navigator.visit(field);
    hand.visit(field);
    field("reckless_time", reckless_time, Range{1.0, 1e6},
          "[s] time after which reckless releases the stick");
    field("script", script, "phases of driver `script`, one per line: path, turn, hold, push");
    robot.visit(field);
    field("replay_t", replay_t, Range{-1e12, 1e12}, "[s] times of the samples that replay plays");
    field("replay_linear", replay_linear, Range{-1.0, 1.0},
          "[1] forward deflection beyond the dead zone at replay_t");
    field("replay_angular", replay_angular, Range{-1.0, 1.0},
          "[1] deflection to the left beyond the dead zone at replay_t");
  }
};

/// Names of all drivers, without modifiers.
[[nodiscard]] const std::vector<std::string>& all_drivers();

/// A parsed driver name: `navigator+tremor` is navigator with tremor. Throws std::invalid_argument
/// that lists all names if a part is unknown.
struct DriverName {
  std::string driver;               ///< one of the drivers
  std::set<std::string> modifiers;  ///< what follows each "+"

  /// Parses "driver+modifier+…". Throws std::invalid_argument on an unknown part.
  explicit DriverName(const std::string& text);
};

/// A simulated person: an intention, and a hand that executes it imperfectly. Deterministic for a
/// seed.
class Driver {
 public:
  /// Throws std::invalid_argument on an unknown name and on parameters that are out of range or
  /// missing.
  Driver(const DriverParams& params, unsigned seed);

  /// The map that the person sees; only the adversary uses it.
  void on_map(std::shared_ptr<const StaticMap> map) { map_ = std::move(map); }

  /// Returns one joystick sample; call every 1 / rate seconds. `X_MB`: the robot; `X_MS`: what the
  /// stick steers, the robot itself or its leader. Releases the dead-man when the driver has
  /// arrived.
  [[nodiscard]] Hand steer(const Pose2& X_MB, const Pose2& X_MS, double t);

  /// Whether the person is done: the route, the script, the time or the recording has ended.
  [[nodiscard]] bool arrived() const;

 private:
  using Person = std::variant<Navigator, Pointer, Script, Reckless, Adversary, Replay>;
  [[nodiscard]] static Person person(const DriverParams& params, const std::string& name,
                                     unsigned seed);
  [[nodiscard]] Hand mean(const Pose2& X_MB, const Pose2& X_MS, double t);

  DriverName name_;
  Person person_;
  HandModel hand_;
  std::shared_ptr<const StaticMap> map_;
};

}  // namespace tandem
