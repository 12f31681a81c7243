// SPDX-License-Identifier: Apache-2.0
#include "safety_filter/people_check.hpp"

#include <algorithm>
#include <cmath>

#include "model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kStep = 0.005;     // [s] between two checks where it gets narrow
constexpr double kFarEnough = 0.5;  // [m] from here on a lower bound of the gap will do
constexpr double kNoNearer = 1e-6;  // [m] rounding

// A first-order motor brakes by a until its speed is a τ, and then decays. Time [s] by which it may
// reach the speed c later than the ramp that counts its lag as delay has ended.
double lateness(double a, double lag, double c) {
  return lag > 0.0 ? lag * std::max(0.0, std::log(a * lag / c) - 2.0) : 0.0;
}

}  // namespace

struct PeopleCheck::Discs {
  struct Disc {
    Eigen::Vector2d p_MC;
    double radius;
  };
  Disc goes_on, runs;  // (1)
};

PeopleCheck::PeopleCheck(const PeopleParams& params, const RobotParams& robot, const Body& body,
                         double brake_spread)
    : params_{params}, body_{body} {
  check(params);
  const double half = 0.5 * std::max(1e-3, params.creep_speed);  // forward and turn share it
  tail_ = std::max(lateness(brake_spread * robot.a_brake, robot.motor_lag, half),
                   lateness(brake_spread * robot.alpha_brake * body.radius, robot.motor_lag, half));
}

double PeopleCheck::fastest_point(const Twist2& twist) const {
  return std::abs(twist.v) + body_.radius * std::abs(twist.w);
}

bool PeopleCheck::creeps(const Motion& motion, const Twist2& measured) const {
  return fastest_point(measured) <= params_.creep_speed &&
         std::all_of(motion.begin(), motion.end(), [&](const Segment& segment) {
           return fastest_point(segment.twist) <= params_.creep_speed;
         });
}

PeopleCheck::Discs PeopleCheck::discs(const Obstacle& person, double tau) const {
  const double v = person.v_MO.norm(), age = tau + params_.people_delay;
  const double radius = person.a + params_.person_error;
  const double strays = 0.5 * v * params_.people_delay + params_.person_speed_error * age +
                        0.5 * params_.person_acceleration * age * age;
  const double fastest = std::max(params_.person_speed, v + params_.person_speed_error);
  return {{person.p_MO + (tau + 0.5 * params_.people_delay) * person.v_MO, radius + strays},
          {person.p_MO, radius + fastest * age}};
}

// From the outline to where the person may be: they are in both discs, so the larger one counts.
double PeopleCheck::gap(const Pose2& X_MB, const Discs& discs) const {
  double gap = -1e9;
  for (const auto& disc : {discs.goes_on, discs.runs}) {
    const double rough = (disc.p_MC - X_MB.position()).norm() - body_.radius - disc.radius;
    gap = std::max(
        gap, rough > kFarEnough
                 ? rough
                 : distance(body_.footprint, transform(inverse(X_MB), disc.p_MC)) - disc.radius);
  }
  return gap;
}

// How fast, up to tau, the edge of either disc may come nearer [m/s].
double PeopleCheck::spreading(const Obstacle& person, double tau) const {
  const double v = person.v_MO.norm(), age = tau + params_.people_delay;
  return std::max(v + params_.person_speed_error + params_.person_acceleration * age,
                  params_.person_speed);
}

bool PeopleCheck::is_far(const PeopleSeen& people, const Pose2& X_MB, double way, double t_start,
                         double duration) const {
  const double tau = std::max(0.0, t_start + duration + tail_ - people.t);
  return std::all_of(people.all.begin(), people.all.end(), [&](const Obstacle& person) {
    return (person.p_MO - X_MB.position()).norm() - body_.radius >
           discs(person, tau).runs.radius + way;
  });
}

bool PeopleCheck::keeps_away(const Motion& motion, const Twist2& measured, const Pose2& X_MB,
                             double t_start, const PeopleSeen& people,
                             const RequiredClearance& required) const {
  const double tau = t_start - people.t;
  const bool creeping = creeps(motion, measured);
  return std::all_of(people.all.begin(), people.all.end(), [&](const Obstacle& person) {
    return creeping ? does_not_near(motion, X_MB, tau, person, required.level)
                    : keeps_away(motion, X_MB, tau, person, required);
  });
}

bool PeopleCheck::keeps_away(const Motion& motion, const Pose2& X_MB, double tau,
                             const Obstacle& person, const RequiredClearance& required) const {
  double duration = tail_;
  for (const auto& segment : motion) duration += segment.dt;
  const double edge = spreading(person, std::max(0.0, tau + duration));
  Pose2 X = X_MB;
  double need = required.level;
  // Conservative advancement in time; between two checks the gap may dip by half a step's worth.
  double free = 0.0;  // [s] that needs no check
  const auto advance = [&](const Twist2& twist, double dt) {
    const WheelSpeeds rims = to_wheels(twist, body_.wheel_separation);
    const double growth = required.per_rim * (std::abs(rims.left) + std::abs(rims.right)) +
                          required.per_path * std::abs(twist.v);
    const double rate = fastest_point(twist) + growth + edge;  // how fast the gap is used up
    for (double rest = dt; rest > 0.0;) {
      const double step = std::min(rest, std::max(free / rate, kStep));
      X = integrate(X, twist, step);
      need += growth * step;
      tau += step;
      rest -= step;
      free -= rate * step;
      if (free > 0.0) continue;
      free = gap(X, discs(person, std::max(0.0, tau))) - need - 0.5 * rate * kStep;
      if (free < 0.0) return false;
    }
    return true;
  };
  for (const auto& [twist, dt] : motion)
    if (!advance(twist, dt)) return false;
  return advance({}, tail_) && gap(X, discs(person, std::max(0.0, tau))) >= need;
}

bool PeopleCheck::does_not_near(const Motion& motion, const Pose2& X_MB, double tau,
                                const Obstacle& person, double level) const {
  const Eigen::Vector2d p_MP = person.p_MO + std::max(0.0, tau) * person.v_MO;
  const double radius = person.a + params_.person_error;
  const auto gap_at = [&](const Pose2& X) {
    return distance(body_.footprint, transform(inverse(X), p_MP)) - radius;
  };
  const double least = std::min(gap_at(X_MB), level) - kNoNearer;
  Pose2 X = X_MB;
  return std::all_of(motion.begin(), motion.end(), [&](const Segment& segment) {
    X = integrate(X, segment.twist, segment.dt);
    return gap_at(X) >= least;
  });
}

}  // namespace tandem
