// SPDX-License-Identifier: Apache-2.0
// Checks the filter's guarantee independently: a world, an outline and a base that share no code
// with the filter, its map or the simulator.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <numbers>
#include <optional>
#include <unordered_map>
#include <vector>

#include "safety_filter/scenes.hpp"

namespace tandem::test {

struct Point {
  double x = 0.0, y = 0.0;
};
using Outline = std::vector<std::vector<Point>>;  // convex parts, in the robot's frame [m]

/// The convex parts of the robot as its parameters describe it.
inline Outline outline_of(const RobotParams& robot) {
  if (robot.footprint.empty()) {
    const double back = robot.center_x - 0.5 * robot.length, front = back + robot.length;
    const double side = 0.5 * robot.width;
    return {{{back, -side}, {front, -side}, {front, side}, {back, side}}};
  }
  Outline outline;
  std::size_t i = 0;
  for (const auto vertices : robot.footprint_parts) {
    outline.emplace_back();
    for (std::size_t k = 0; k < static_cast<std::size_t>(vertices); ++k, i += 2)
      outline.back().push_back({robot.footprint[i], robot.footprint[i + 1]});
  }
  return outline;
}

inline double radius_of(const Outline& outline) {
  double radius = 0.0;
  for (const auto& part : outline)
    for (const Point& p : part) radius = std::max(radius, std::hypot(p.x, p.y));
  return radius;
}

/// A robot's pose [m, m, rad].
struct Placement {
  double x = 0.0, y = 0.0, heading = 0.0;
};

/// Square cells in a spatial hash.
class CellWorld {
 public:
  CellWorld(double size, double side) : size_{size}, side_{side} {}

  void add(int ix, int iy) { cells_.push_back({(ix + 0.5) * side_, (iy + 0.5) * side_}); }
  /// Adds every cell whose centre satisfies inside(x, y).
  template <class Inside>
  void add_where(const Inside& inside) {
    const int half = static_cast<int>(0.5 * size_ / side_);
    for (int iy = -half; iy < half; ++iy)
      for (int ix = -half; ix < half; ++ix)
        if (inside((ix + 0.5) * side_, (iy + 0.5) * side_)) add(ix, iy);
  }
  /// Call once after all cells were added.
  void sort_into_buckets() {
    for (const Point& cell : cells_) buckets_[key(bucket(cell.x), bucket(cell.y))].push_back(cell);
  }

  [[nodiscard]] double size() const { return size_; }
  [[nodiscard]] double side() const { return side_; }
  [[nodiscard]] const std::vector<Point>& cells() const { return cells_; }

  template <class Visit>
  void near(double x, double y, double radius, const Visit& visit) const {
    for (int j = bucket(y - radius); j <= bucket(y + radius); ++j)
      for (int i = bucket(x - radius); i <= bucket(x + radius); ++i)
        if (const auto found = buckets_.find(key(i, j)); found != buckets_.end())
          for (const Point& cell : found->second) visit(cell);
  }

  /// The same world in the form that the filter takes.
  [[nodiscard]] std::shared_ptr<const StaticMap> as_static_map() const {
    Grid grid = free_grid(size_, side_);
    for (const Point& cell : cells_)
      grid.cells[grid.index(static_cast<int>((cell.x - grid.origin.x()) / side_),
                            static_cast<int>((cell.y - grid.origin.y()) / side_))] =
          Cell::kOccupied;
    return as_map(std::move(grid));
  }

 private:
  static constexpr double kBucket = 0.5;  // [m]
  static int bucket(double value) { return static_cast<int>(std::floor(value / kBucket)); }
  static std::int64_t key(int i, int j) { return (static_cast<std::int64_t>(i) << 32) + j; }

  double size_, side_;
  std::vector<Point> cells_;
  std::unordered_map<std::int64_t, std::vector<Point>> buckets_;
};

/// Gap between a convex part and a square along the axis on which they are furthest apart: below 0
/// only if they overlap, and never more than their distance (separating axis theorem) [m].
inline double separation(const std::vector<Point>& part, const Point& cell, double half) {
  double x_low = 1e9, x_high = -1e9, y_low = 1e9, y_high = -1e9;
  for (const Point& p : part) {
    x_low = std::min(x_low, p.x);
    x_high = std::max(x_high, p.x);
    y_low = std::min(y_low, p.y);
    y_high = std::max(y_high, p.y);
  }
  double gap = std::max({cell.x - half - x_high, x_low - cell.x - half, cell.y - half - y_high,
                         y_low - cell.y - half});
  for (std::size_t i = 0; i < part.size(); ++i) {
    const Point& a = part[i];
    const Point& b = part[(i + 1) % part.size()];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const double nx = (b.y - a.y) / length, ny = -(b.x - a.x) / length;  // outward
    gap = std::max(
        gap, nx * (cell.x - a.x) + ny * (cell.y - a.y) - half * (std::abs(nx) + std::abs(ny)));
  }
  return gap;
}

/// Lower bound of the outline's clearance, at most `reach`; negative exactly if it overlaps a cell.
inline double clearance_bound(const Outline& outline, const Placement& at, const CellWorld& world,
                              double reach) {
  const double c = std::cos(at.heading), s = std::sin(at.heading), half = 0.5 * world.side();
  const double radius = radius_of(outline);
  double least = reach;
  for (const auto& part : outline) {
    std::vector<Point> placed;
    for (const Point& p : part)
      placed.push_back({at.x + c * p.x - s * p.y, at.y + s * p.x + c * p.y});
    world.near(at.x, at.y, radius + reach + world.side(), [&](const Point& cell) {
      if (std::hypot(cell.x - at.x, cell.y - at.y) - radius - 1.5 * half >= least) return;
      least = std::min(least, separation(placed, cell, half));
    });
  }
  return least;
}

/// How the base behaves within (or beyond) the bounds that the filter assumes.
struct BaseBehaviour {
  double lag = 0.0;                      // τ of both motors [s]
  double brake = 1.0, turn_brake = 1.0;  // [m/s², rad/s²]
  double drive = 5.0, turn_drive = 10.0;
  double slip_left = 0.0, slip_right = 0.0;          // [1]
  double slip_period = 0.0;                          // of their sinusoid; 0: constant [s]
  double shortest_delay = 0.0, longest_delay = 0.0;  // of commands [s]
  double timeout = 0.0;
};

/// A differential drive in a world of cells; integrates equation (1) of stopping_motion.hpp in
/// small steps.
class Base {
 public:
  Base(const RobotParams& robot, const BaseBehaviour& behaviour, const CellWorld& world,
       Random& random)
      : outline_{outline_of(robot)},
        radius_{radius_of(outline_)},
        wheel_separation_{robot.wheel_separation},
        behaviour_{behaviour},
        world_{world},
        random_{random} {}

  void start_at(const Placement& at) {
    at_ = at;
    v_ = w_ = u_v_ = u_w_ = 0.0;
    pending_.clear();
    past_.clear();
    spare_ = 0.0;
    touched_ = false;
    remember();
  }
  void command(double v, double w) {
    const double delay = uniform(random_, behaviour_.shortest_delay, behaviour_.longest_delay);
    const double earliest = pending_.empty() ? 0.0 : pending_.back().due;
    pending_.push_back({std::max(t_ + delay, earliest), v, w});
  }
  void advance_to(double t) {
    while (t - t_ > 1e-9) step(std::min(kStep, t - t_));
  }

  struct State {
    double t = 0.0;
    Placement at;
    double v = 0.0, w = 0.0;  // as measured by the wheel encoders
    Placement odometry;       // from the encoders alone
  };
  /// The measurement of `age` ago.
  [[nodiscard]] const State& ago(double age) const {
    for (auto state = past_.rbegin(); state != past_.rend(); ++state)
      if (state->t <= t_ - age + 1e-9) return *state;
    return past_.front();
  }
  [[nodiscard]] const Placement& at() const { return at_; }
  [[nodiscard]] const Outline& outline() const { return outline_; }
  [[nodiscard]] double radius() const { return radius_; }
  [[nodiscard]] double time() const { return t_; }
  [[nodiscard]] bool touched() const { return touched_; }
  [[nodiscard]] bool stands() const { return std::abs(v_) < 1e-3 && std::abs(w_) < 1e-3; }
  [[nodiscard]] double min_clearance() const { return min_clearance_; }
  [[nodiscard]] double travel() const { return travel_; }

 private:
  static constexpr double kStep = 0.002;  // [s]
  static constexpr double kMemory = 2.0;  // [s]
  static constexpr double kLook = 0.5;    // [m]
  static constexpr double kTouch = 1e-6;  // [m] of rounding
  struct Pending {
    double due, v, w;
  };

  void step(double dt) {
    take_commands();
    const double v = follow(v_, u_v_, behaviour_.brake, behaviour_.drive, dt);
    const double w = follow(w_, u_w_, behaviour_.turn_brake, behaviour_.turn_drive, dt);
    move(0.5 * (v_ + v), 0.5 * (w_ + w), dt);
    count_wheels(0.5 * (v_ + v), 0.5 * (w_ + w), dt);
    v_ = v;
    w_ = w;
    t_ += dt;
    remember();
  }
  void take_commands() {
    for (; !pending_.empty() && pending_.front().due <= t_; pending_.pop_front()) {
      u_v_ = pending_.front().v;
      u_w_ = pending_.front().w;
      heard_ = t_;
    }
    if (behaviour_.timeout > 0.0 && t_ - heard_ > behaviour_.timeout) u_v_ = u_w_ = 0.0;
  }
  [[nodiscard]] double follow(double speed, double target, double brake, double drive,
                              double dt) const {
    const double share = behaviour_.lag > 0.0 ? -std::expm1(-dt / behaviour_.lag) : 1.0;
    const double change = share * (target - speed);
    const bool slows = change * speed < 0.0;
    const double most = (slows ? brake : drive) * dt;
    return speed + std::min(most, std::max(-most, change));
  }
  void move(double v, double w, double dt) {
    const double phase = behaviour_.slip_period > 0.0
                             ? std::cos(2.0 * std::numbers::pi * t_ / behaviour_.slip_period)
                             : 1.0;
    const double left = (v - 0.5 * wheel_separation_ * w) * (1.0 + phase * behaviour_.slip_left);
    const double right = (v + 0.5 * wheel_separation_ * w) * (1.0 + phase * behaviour_.slip_right);
    const double way = 0.5 * (left + right) * dt, turn = (right - left) / wheel_separation_ * dt;
    at_.x += way * std::cos(at_.heading + 0.5 * turn);
    at_.y += way * std::sin(at_.heading + 0.5 * turn);
    at_.heading += turn;
    travel_ += std::abs(way);
    spare_ -= std::abs(way) + radius_ * std::abs(turn);
    if (spare_ > 0.0) return;
    spare_ = clearance_bound(outline_, at_, world_, kLook);
    min_clearance_ = std::min(min_clearance_, spare_);
    touched_ = touched_ || spare_ < -kTouch;
  }
  void count_wheels(double v, double w, double dt) {
    odometry_.x += v * dt * std::cos(odometry_.heading + 0.5 * w * dt);
    odometry_.y += v * dt * std::sin(odometry_.heading + 0.5 * w * dt);
    odometry_.heading += w * dt;
  }
  void remember() {
    past_.push_back({t_, at_, v_, w_, odometry_});
    while (past_.front().t < t_ - kMemory) past_.pop_front();
  }

  Outline outline_;
  double radius_, wheel_separation_;
  BaseBehaviour behaviour_;
  const CellWorld& world_;
  Random& random_;
  Placement at_, odometry_;
  double v_ = 0.0, w_ = 0.0, u_v_ = 0.0, u_w_ = 0.0, t_ = 0.0, heard_ = 0.0;
  std::deque<Pending> pending_;
  std::deque<State> past_;
  double spare_ = 0.0;  // distance that the outline's fastest point may travel before the next
                        // contact check [m]
  double min_clearance_ = 1.0, travel_ = 0.0;
  bool touched_ = false;
};

}  // namespace tandem::test
