// SPDX-License-Identifier: Apache-2.0
// Generates commands that try to make a robot hit something, from its true pose.
#pragma once

#include <limits>

#include "safety_filter/oracle.hpp"

namespace tandem::test {

enum class Plan {
  kRandom,         ///< a new extreme at every call
  kHeldExtremes,   ///< an extreme for up to two seconds, then another
  kBangBang,       ///< alternating between sides and between forward and backward
  kPush,           ///< straight at a cell at full speed, without stopping
  kGraze,          ///< past a cell at full speed, as close as possible
  kPushAndTurn,    ///< straight at a cell, then at full turn rate to one side when near it
  kTowardNearest,  ///< whatever moves the outline toward the nearest cell
  kNotFinite,      ///< bursts of NaN and infinity amid a push
};
inline constexpr int kPlans = 8;

class Attack {
 public:
  Attack(Plan plan, const RobotParams& robot, const CellWorld& world, Random& random)
      : plan_{plan}, robot_{robot}, world_{world}, random_{random} {}

  Twist2 command(const Placement& at, double t) {
    if (t >= until_) choose(at, t);
    ++calls_;
    switch (plan_) {
      case Plan::kRandom:
        return extreme();
      case Plan::kHeldExtremes:
        return held_;
      case Plan::kBangBang:
        return {calls_ / 2 % 2 ? robot_.v_min : robot_.v_max,
                calls_ % 2 ? robot_.w_max : -robot_.w_max};
      case Plan::kPush:
      case Plan::kGraze:
        return toward_aim(at);
      case Plan::kPushAndTurn:
        return distance_to_target(at) < turn_at_ ? Twist2{robot_.v_max, turn_} : toward_aim(at);
      case Plan::kTowardNearest:
        return toward_nearest(at);
      case Plan::kNotFinite:
        return calls_ % 5 < 2 ? not_finite() : toward_aim(at);
    }
    return {};
  }

 private:
  Twist2 extreme() {
    const std::array<double, 4> v{robot_.v_max, robot_.v_max, robot_.v_min,
                                  uniform(random_, robot_.v_min, robot_.v_max)};
    const std::array<double, 4> w{robot_.w_max, -robot_.w_max, 0.0,
                                  uniform(random_, -robot_.w_max, robot_.w_max)};
    return {v[static_cast<std::size_t>(pick(random_, 4))],
            w[static_cast<std::size_t>(pick(random_, 4))]};
  }
  Twist2 not_finite() {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInf = std::numeric_limits<double>::infinity();
    const std::array<Twist2, 4> all{Twist2{kNaN, robot_.w_max}, Twist2{robot_.v_max, kNaN},
                                    Twist2{kInf, -kInf}, Twist2{-kInf, robot_.w_max}};
    return all[static_cast<std::size_t>(pick(random_, 4))];
  }

  // Picks another target: the cell nearest to a random point within a few seconds' drive.
  void choose(const Placement& at, double t) {
    held_ = extreme();
    turn_ = pick(random_, 2) ? robot_.w_max : -robot_.w_max;
    turn_at_ = uniform(random_, 0.0, 1.5 + robot_.v_max);
    backward_ = pick(random_, 4) == 0;
    const bool held = plan_ == Plan::kHeldExtremes;
    until_ = t + (held ? uniform(random_, 0.05, 2.0) : uniform(random_, 3.0, 12.0));
    const double angle = uniform(random_, -std::numbers::pi, std::numbers::pi);
    const double away = uniform(random_, 0.5, 2.0 + 2.0 * robot_.v_max);
    const Point place{at.x + away * std::cos(angle), at.y + away * std::sin(angle)};
    target_ = {place.x, place.y};
    double nearest = 4.0;
    world_.near(place.x, place.y, nearest, [&](const Point& cell) {
      const double d = std::hypot(cell.x - place.x, cell.y - place.y);
      if (d >= nearest) return;
      nearest = d;
      target_ = cell;
    });
    aim_ = target_;
    if (plan_ != Plan::kGraze) return;
    // Aims beside the cell, by half of the robot's width plus the filter's margin.
    const double beside = (pick(random_, 2) ? 1.0 : -1.0) *
                          (0.5 * robot_.width + 0.7 * world_.side() + uniform(random_, 0.0, 0.08));
    const double to = std::atan2(target_.y - at.y, target_.x - at.x);
    aim_ = {target_.x - beside * std::sin(to), target_.y + beside * std::cos(to)};
    // Aims beyond it, so that the path past the cell is straight.
    aim_ = {aim_.x + 3.0 * std::cos(to), aim_.y + 3.0 * std::sin(to)};
  }

  [[nodiscard]] double distance_to_target(const Placement& at) const {
    return std::hypot(target_.x - at.x, target_.y - at.y);
  }
  [[nodiscard]] Twist2 toward_aim(const Placement& at) const {
    double off = std::remainder(std::atan2(aim_.y - at.y, aim_.x - at.x) - at.heading +
                                    (backward_ ? std::numbers::pi : 0.0),
                                2.0 * std::numbers::pi);
    const double w = std::clamp(4.0 * off, -robot_.w_max, robot_.w_max);
    const double full = backward_ ? robot_.v_min : robot_.v_max;
    return {std::abs(off) < 0.3 ? full : 0.1 * full, w};
  }
  // Signs that move the outline's point nearest to a cell straight at that cell.
  [[nodiscard]] Twist2 toward_nearest(const Placement& at) const {
    const double c = std::cos(at.heading), s = std::sin(at.heading);
    const double back = robot_.center_x - 0.5 * robot_.length, half = 0.5 * robot_.width;
    double nearest = 1.0, px = 0.0, py = 0.0, gx = 0.0, gy = 0.0;
    world_.near(at.x, at.y, 2.5, [&](const Point& cell) {
      const double x = c * (cell.x - at.x) + s * (cell.y - at.y);
      const double y = -s * (cell.x - at.x) + c * (cell.y - at.y);
      const double qx = std::clamp(x, back, back + robot_.length), qy = std::clamp(y, -half, half);
      const double d = std::hypot(x - qx, y - qy);
      if (d >= nearest) return;
      nearest = d;
      px = qx, py = qy, gx = x - qx, gy = y - qy;
    });
    if (nearest >= 1.0) return toward_aim(at);
    const double forward = std::abs(gx) > 0.1 * std::abs(gy) ? gx : held_.v;
    return {forward > 0.0 ? robot_.v_max : robot_.v_min,
            px * gy - py * gx > 0.0 ? robot_.w_max : -robot_.w_max};
  }

  Plan plan_;
  RobotParams robot_;
  const CellWorld& world_;
  Random& random_;
  Twist2 held_;
  Point target_, aim_;
  double turn_ = 0.0, turn_at_ = 0.0, until_ = -1.0;
  bool backward_ = false;
  int calls_ = 0;
};

}  // namespace tandem::test
