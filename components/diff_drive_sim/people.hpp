// SPDX-License-Identifier: Apache-2.0
// In: where people want to walk. Out: where they are, and how fast, at each moment.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tandem/model/obstacle.hpp"

namespace tandem {

/// A person from above, a disc, who walks to and fro along a way; with one point, stands there.
struct Walker {
  double radius = 0.25;               ///< [m]
  double speed = 1.0;                 ///< [m/s]
  std::vector<Eigen::Vector2d> p_MW;  ///< points of the way, at least one; the first is the start
};

/// Walkers as one list of numbers: for each the radius, the speed, how many points, x1, y1, … The
/// way back throws std::invalid_argument on a list of another form, a radius that is not above 0,
/// or a speed below 0.
[[nodiscard]] std::vector<double> to_numbers(std::span<const Walker> walkers);
[[nodiscard]] std::vector<Walker> walkers_of(std::span<const double> numbers);

/// People who cross a rectangle, each between two points on opposite sides of it.
struct Crossings {
  int count = 0;
  Eigen::Vector2d low{0.0, 0.0}, high{0.0, 0.0};  ///< corners of the rectangle [m]
  double slowest = 0.5, fastest = 1.3;            ///< [m/s]
  double radius = 0.25;                           ///< [m]
};

/// The crossings of a seed; nobody starts within `kStartGap` of p_MB.
inline constexpr double kStartGap = 1.5;  // [m]
[[nodiscard]] std::vector<Walker> crossing_people(const Crossings& crossings, unsigned seed,
                                                  const Eigen::Vector2d& p_MB);

/// People who see nothing: they walk through whatever is in their way.
///
///   dv/dt = a e,   e toward  speed · (direction of the next point) − v,   at most `acceleration`
///
/// so that neither speed nor acceleration is ever above its bound. Who starts on a way starts at
/// full speed.
class People {
 public:
  static constexpr double kArrived = 0.3;  ///< [m] this near to a point they turn to the next

  People() = default;
  People(std::vector<Walker> walkers, double acceleration);

  /// All back to where they start.
  void restart();
  /// Person i goes along another way from where they are.
  void send(std::size_t i, std::vector<Eigen::Vector2d> p_MW);
  void advance(double dt);

  /// Where they are, as discs with their velocity, in the order given.
  [[nodiscard]] const std::vector<Obstacle>& all() const { return all_; }
  /// First person along the ray from p_MQ at `heading`: distance [m], at most `max_range`; 0 within
  /// one.
  [[nodiscard]] double cast_ray(const Eigen::Vector2d& p_MQ, double heading,
                                double max_range) const;

 private:
  /// Which point a walker goes to, and whether along the way or back.
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
