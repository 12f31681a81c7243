// SPDX-License-Identifier: Apache-2.0
// The filter's promise as a property: closed-loop rollouts to standstill in random worlds, with
// random robots, delays and malice. One definition for the test and for the long run by hand.
#pragma once

#include <algorithm>

#include "adversary.hpp"

namespace tandem::test {

/// How far the real base goes beyond what the filter was told, as multiples of each bound.
struct Beyond {
  double slip = 1.0;        ///< of the wheels' travel
  double lag = 1.0;         ///< of the motors
  double delay = 1.0;       ///< of commands and of odometry
  double pose_error = 1.0;  ///< of the localiser
  double braking = 1.0;     ///< the base brakes by this factor more weakly than a_brake
};

/// What a number of rollouts came to.
struct Tally {
  long steps = 0;             ///< calls of the filter
  long rollouts = 0;          ///< to standstill
  long contacts = 0;          ///< with people: while the robot moved itself
  long walked_into = 0;       ///< by people, while it stood
  unsigned contact_seed = 0;  ///< a scene with a contact
  unsigned closest_seed = 0;  ///< the scene of min_clearance
  long unfinished = 0;        ///< did not come to rest
  double min_clearance = 1.0;
  double travel = 0.0;  ///< [m]

  void add(const Tally& other) {
    steps += other.steps;
    rollouts += other.rollouts;
    if (contacts == 0) contact_seed = other.contact_seed;
    contacts += other.contacts;
    walked_into += other.walked_into;
    unfinished += other.unfinished;
    if (other.min_clearance < min_clearance) closest_seed = other.closest_seed;
    min_clearance = std::min(min_clearance, other.min_clearance);
    travel += other.travel;
  }
};

inline constexpr int kRolloutsPerScene = 20;
inline constexpr int kRolloutsPerStart = 4;   // then from somewhere else, to get up speed again
inline constexpr double kLongestRest = 20.0;  // [s] by then the robot must stand

/// Full-speed malice for some ticks, then no command, or no filter, until the robot stands.
inline void roll_out(ClosedLoop& loop, Malice malice, const RobotParams& robot,
                     const StaticMap& map, double pose_error, Random& random, Tally& tally) {
  const double control_period = loop.filter().params().control_period;
  Adversary adversary(malice, robot, random);
  loop.draw_pose_error(pick(random, 2) == 0, pose_error);
  const int ticks = 6 + pick(random, 14);
  for (int i = 0; i < ticks; ++i) {
    const Pose2 before = loop.sim().state().X_MB;
    const double period = pick(random, 2) ? control_period : uniform(random, 0.02, control_period);
    (void)loop.tick(adversary.command(before, loop.sim().footprint(), map), period);
    tally.travel += (loop.sim().state().X_MB.position() - before.position()).norm();
  }
  if (loop.filter().params().survive_silence && pick(random, 2)) loop.be_silent(1.0);
  const int longest = static_cast<int>(kLongestRest / control_period);
  int waited = 0;
  for (; waited < longest && (waited < 3 || !loop.stands()); ++waited)
    (void)loop.tick({}, control_period);
  tally.steps += ticks + waited;
  ++tally.rollouts;
  tally.unfinished += loop.stands() ? 0 : 1;
}

/// The base as it really is: worse than `robot` says where `beyond` is above 1.
inline RobotParams real_robot(RobotParams robot, const Beyond& beyond) {
  robot.motor_lag *= beyond.lag;
  robot.command_delay *= beyond.delay;
  robot.sensor_delay *= beyond.delay;
  robot.a_brake /= beyond.braking;
  robot.alpha_brake /= beyond.braking;
  return robot;
}

/// kRolloutsPerScene rollouts in the world, and with the robot, of that seed.
[[nodiscard]] inline Tally run_scene(unsigned seed, const Beyond& beyond = {},
                                     RobotParams (*draw_robot)(Random&) = random_robot) {
  Tally tally;
  Random random(seed);
  SafetyFilterParams params;
  params.survive_silence = pick(random, 2) == 0;
  const RobotParams robot = draw_robot(random);
  const auto map = random_map(random, pick(random, 2) ? 0.05 : 0.1);
  DiffDriveSimParams base = random_base(random, params);
  base.drive.slip *= beyond.slip;
  ClosedLoop loop(params, robot, base, real_robot(robot, beyond), map, random);
  for (int i = 0; i < kRolloutsPerScene; ++i) {
    if (i % kRolloutsPerStart == 0) {
      Pose2 start;
      if (!find_free_pose(random, *map, loop.sim().footprint(), 0.06, start)) break;
      loop.start_at(start);
    }
    roll_out(loop, static_cast<Malice>(pick(random, kMalices)), robot, *map, beyond.pose_error,
             random, tally);
    tally.min_clearance = std::min(tally.min_clearance, loop.sim().min_clearance());
    if (i % kRolloutsPerStart == kRolloutsPerStart - 1)
      tally.contacts += loop.sim().contacts().count;
  }
  if (tally.contacts > 0) tally.contact_seed = seed;
  tally.closest_seed = seed;
  return tally;
}

}  // namespace tandem::test
