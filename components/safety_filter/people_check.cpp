// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/people_check.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kStep = 0.005;     // [s] between two checks when the gap is small
constexpr double kFarEnough = 0.5;  // [m] beyond this a lower bound of the gap suffices
constexpr double kNoNearer = 1e-6;  // [m] rounding tolerance

// For a creep_speed below kTailSpeed: how much later than the envelope's end the motor's
// exponential tail reaches the speed c [s]. The envelope covers the travel of the tail below
// kTailSpeed in one lag.
double lateness(double lag, double c) {
  return lag * std::max(0.0, std::log(kTailSpeed / c) - 1.0);
}

}  // namespace

struct PeopleCheck::Discs {
  struct Disc {
    Eigen::Vector2d p_MC;
    double radius;
  };
  Disc goes_on, runs;  // (1)
};

// Arguments of keeps_away() that are the same for every person.
struct PeopleCheck::Look {
  const StoppingEnvelope& envelope;
  const ShareCell& cell;
  const Pose2& X_MB;
  double tau;  // [s] from the list of people to the motion's start
  double level;
  const DriftBounds& drift;
};

PeopleCheck::PeopleCheck(const PeopleParams& params, const RobotParams& robot,
                         const BoundedFootprint& body)
    : params_{params}, body_{body} {
  check(params);
  // Half of creep_speed each for forward speed and for turning.
  const double half = 0.5 * std::max(1e-3, params.creep_speed);
  tail_ = lateness(robot.motor_lag, half / std::max(1.0, body.radius));
}

double PeopleCheck::fastest_point(const Twist2& twist) const {
  return std::abs(twist.v) + body_.radius * std::abs(twist.w);
}

bool PeopleCheck::creeps(const Look& look, const Twist2& measured) const {
  return fastest_point(measured) <= params_.creep_speed &&
         std::all_of(look.envelope.begin(), look.envelope.end(), [&](const TwistRange& range) {
           return fastest_point(center_twist(range, look.cell)) +
                      fastest_point(half_width(range, look.cell)) <=
                  params_.creep_speed;
         });
}

PeopleCheck::Discs PeopleCheck::discs(const Obstacle& person, double tau) const {
  const double v = person.v_MO.norm(), age = tau + params_.people_delay;
  const double radius = circumradius(person) + params_.person_error;
  const double strays = 0.5 * v * params_.people_delay + params_.person_speed_error * age +
                        0.5 * params_.person_acceleration * age * age;
  const double fastest = std::max(params_.person_speed, v + params_.person_speed_error);
  return {{person.p_MO + (tau + 0.5 * params_.people_delay) * person.v_MO, radius + strays},
          {person.p_MO, radius + fastest * age}};
}

// Gap from the outline to where the person may be. The person is in both discs, so the larger gap
// holds [m].
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

// Upper bound until tau on the speed at which the edge of either disc approaches [m/s].
double PeopleCheck::spreading(const Obstacle& person, double tau) const {
  const double v = person.v_MO.norm(), age = tau + params_.people_delay;
  return std::max(v + params_.person_speed_error + params_.person_acceleration * age,
                  params_.person_speed);
}

bool PeopleCheck::is_far(const PeopleSeen& people, const Pose2& X_MB, double way, double t_start,
                         double duration) const {
  const double tau = std::max(0.0, people.age(t_start + duration + tail_));
  return std::all_of(people.value.begin(), people.value.end(), [&](const Obstacle& person) {
    return (person.p_MO - X_MB.position()).norm() - body_.radius >
           discs(person, tau).runs.radius + way;
  });
}

bool PeopleCheck::keeps_away(const StoppingEnvelope& envelope, const ShareCell& cell,
                             const Twist2& measured, const Pose2& X_MB, double t_start,
                             const PeopleSeen& people, double level,
                             const DriftBounds& drift) const {
  const Look look{envelope, cell, X_MB, people.age(t_start), level, drift};
  const bool creeping = creeps(look, measured);
  return std::all_of(people.value.begin(), people.value.end(), [&](const Obstacle& person) {
    return creeping ? does_not_near(look, person) : keeps_away(look, person);
  });
}

// Speeds only fall toward the end of an envelope, so no speed in a range exceeds the mean of the
// range before it.
std::span<const TwistRange> PeopleCheck::until_standing(const StoppingEnvelope& envelope) const {
  std::size_t count = envelope.size();
  const auto stands = [&](const TwistRange& range) {
    return std::max(std::abs(range.low.v), std::abs(range.high.v)) +
               body_.radius * std::max(std::abs(range.low.w), std::abs(range.high.w)) <=
           params_.creep_speed;
  };
  while (count > 1 && stands(envelope[count - 1]) && stands(envelope[count - 2])) --count;
  return {envelope.data(), count};
}

bool PeopleCheck::keeps_away(const Look& look, const Obstacle& person) const {
  const auto moving = until_standing(look.envelope);
  const double tail = moving.size() == look.envelope.size() ? tail_ : 0.0;
  double duration = tail;
  for (const auto& range : moving) duration += range.dt;
  const double edge = spreading(person, std::max(0.0, look.tau + duration));
  Pose2 X = look.X_MB;
  double tau = look.tau;
  Deviation deviation{look.drift};
  const auto in_hand = [&] {
    return gap(X, discs(person, std::max(0.0, tau))) - look.level - deviation.outline();
  };
  // Conservative advancement in time; between two checks the gap may drop by half a step's change.
  double free = 0.0;  // [m] part of the gap that needs no check
  const auto advance = [&](const Twist2& twist, const Twist2& tolerance, double dt) {
    for (double rest = dt; rest > 0.0;) {
      // Upper bound on the rate at which the gap closes [m/s].
      const double rate = fastest_point(twist) + deviation.rate(twist, tolerance, rest) + edge;
      const double step = std::min(rest, std::max(free / rate, kStep));
      X = integrate(X, twist, step);
      deviation.advance(twist, tolerance, step);
      tau += step;
      rest -= step;
      free -= rate * step;
      if (free > 0.0) continue;
      free = in_hand() - 0.5 * rate * kStep;
      if (free < 0.0) return false;
    }
    return true;
  };
  for (const auto& range : moving)
    if (!advance(center_twist(range, look.cell), half_width(range, look.cell), range.dt))
      return false;
  return advance({}, {}, tail) && in_hand() >= 0.0;
}

bool PeopleCheck::does_not_near(const Look& look, const Obstacle& person) const {
  const Eigen::Vector2d p_MP = person.p_MO + std::max(0.0, look.tau) * person.v_MO;
  const double radius = circumradius(person) + params_.person_error;
  const auto gap_at = [&](const Pose2& X) {
    return distance(body_.footprint, transform(inverse(X), p_MP)) - radius;
  };
  const double least = std::min(gap_at(look.X_MB), look.level) - kNoNearer;
  Pose2 X = look.X_MB;
  double strays = 0.0;  // deviation of the cell's other motions from its centre [m]
  return std::all_of(look.envelope.begin(), look.envelope.end(), [&](const TwistRange& range) {
    X = integrate(X, center_twist(range, look.cell), range.dt);
    strays += fastest_point(half_width(range, look.cell)) * range.dt;
    return gap_at(X) - strays >= least;
  });
}

}  // namespace tandem
