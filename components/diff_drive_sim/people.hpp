// SPDX-License-Identifier: Apache-2.0
// Simulates people who walk along given paths.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tandem/model/obstacle.hpp"

namespace tandem {

/// A person, seen from above as a disc, who walks to and fro along a path; with one point they
/// stand there.
struct Walker {
  double radius = 0.25;               ///< [m]
  double speed = 1.0;                 ///< [m/s]
  std::vector<Eigen::Vector2d> p_MW;  ///< points of the path, at least one; the first is the start
};

/// Converts walkers to one list of numbers: radius, speed, number of points, x1, y1, … for each.
/// walkers_of converts back and throws std::invalid_argument on a malformed list, a radius that is
/// not above 0, or a speed below 0.
[[nodiscard]] std::vector<double> to_numbers(std::span<const Walker> walkers);
/// The inverse of to_numbers().
[[nodiscard]] std::vector<Walker> walkers_of(std::span<const double> numbers);

/// People who cross a rectangle, each between two points on opposite sides.
struct Crossings {
  int count = 0;                                  ///< number of people
  Eigen::Vector2d low{0.0, 0.0}, high{0.0, 0.0};  ///< corners of the rectangle [m]
  double slowest = 0.5, fastest = 1.3;            ///< [m/s]
  double radius = 0.25;                           ///< [m]
};

/// Distance from the robot within which nobody starts.
inline constexpr double kStartGap = 1.5;  ///< [m]
/// The walkers of a seed; nobody starts within kStartGap of p_MB [m].
[[nodiscard]] std::vector<Walker> crossing_people(const Crossings& crossings, unsigned seed,
                                                  const Eigen::Vector2d& p_MB);

/// People who do not see: they walk through whatever is in their path.
///
///   dv/dt = a e,   e toward  speed · (direction of the next point) − v,   at most `acceleration`
///
/// so that neither speed nor acceleration ever exceeds its limit. Walkers start at full speed.
class People {
 public:
  static constexpr double kArrived = 0.3;       ///< [m] distance at which they turn to the next
  static constexpr double kAcceleration = 1.0;  ///< [m/s²] of the simulator's people

  People() = default;
  /// Everybody at their start. `acceleration`: how fast people change their velocity [m/s²].
  People(std::vector<Walker> walkers, double acceleration);

  /// Returns all people to their starts.
  void restart();
  /// Gives person i another path, from where they are now.
  void send(std::size_t i, std::vector<Eigen::Vector2d> p_MW);
  /// Moves everybody for `dt` [s].
  void advance(double dt);

  /// All people as discs with their velocity, in the order given.
  [[nodiscard]] const std::vector<Obstacle>& all() const { return all_; }
  /// Distance to the first person along the ray from p_MQ at `heading` [m], at most `max_range`; 0
  /// inside a person.
  [[nodiscard]] double cast_ray(const Eigen::Vector2d& p_MQ, double heading,
                                double max_range) const;

 private:
  /// A walker's next point, and whether they walk back along the path.
  struct Heading {
    std::size_t next = 0;
    bool back = false;
  };

  void turn_to_next(std::size_t i);

  std::vector<Walker> walkers_;
  double acceleration_ = 1.0;  // [m/s²]
  std::vector<Obstacle> all_;
  std::vector<Heading> headings_;
};

}  // namespace tandem
