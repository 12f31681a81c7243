// SPDX-License-Identifier: Apache-2.0
// Passive safety as a property: people try to be hit, and so does the operator. Shared by the test
// and by the long run started by hand.
#pragma once

#include "safety_filter/adversary.hpp"
#include "safety_filter/rollouts.hpp"

namespace tandem::test {

/// People within the filter's bounds who walk straight at the robot, walk to where it is going, or
/// stand beside it and then dash.
class Hunters {
 public:
  Hunters(ClosedLoop& loop, Random& random, const PeopleParams& bounds)
      : loop_{loop}, random_{random} {
    std::vector<Walker> walkers;
    for (int i = 1 + pick(random, 3); i > 0; --i) {
      walkers.push_back({uniform(random, 0.1, 0.35),
                         uniform(random, 0.2, 1.0) * bounds.person_speed,
                         {somewhere(), somewhere()}});
      patience_.push_back(pick(random, 3) ? 0 : 1 + pick(random, 40));
    }
    loop.sim().put({std::move(walkers), bounds.person_acceleration});
  }

  void hunt() {
    ++tick_;
    const SimState& robot = loop_.sim().state();
    for (std::size_t i = 0; i < patience_.size(); ++i) {
      const Obstacle& person = loop_.sim().people().all()[i];
      const bool waits = patience_[i] > 0 && (tick_ / patience_[i]) % 2 == 0;
      const double ahead = uniform(random_, 0.0, 0.8);  // [s]
      const Eigen::Vector2d to = integrate(robot.X_MB, robot.twist, ahead).position() - person.p_MO;
      if (waits || to.norm() < 1e-3)
        loop_.sim().people().send(i, {person.p_MO});
      else
        loop_.sim().people().send(i, {person.p_MO, person.p_MO + 5.0 / to.norm() * to});
    }
  }

 private:
  Eigen::Vector2d somewhere() {
    const double angle = uniform(random_, -std::numbers::pi, std::numbers::pi);
    return uniform(random_, 1.5, 4.0) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }

  ClosedLoop& loop_;
  Random& random_;
  std::vector<int> patience_;  // ticks of standing, then of dashing; 0: neither
  int tick_ = 0;
};

/// Commands full speed toward the nearest person.
inline Twist2 at_nearest_person(const DiffDriveSim& sim, const RobotParams& robot) {
  Eigen::Vector2d p_BP{1.0, 0.0};
  double nearest = 1e9;
  for (const Obstacle& person : sim.people().all()) {
    const Eigen::Vector2d p = transform(inverse(sim.state().X_MB), person.p_MO);
    if (p.norm() >= nearest) continue;
    nearest = p.norm();
    p_BP = p;
  }
  return {p_BP.x() > 0.0 ? robot.v_max : robot.v_min,
          std::copysign(robot.w_max, p_BP.x() * p_BP.y())};
}

inline constexpr int kPeopleTicks = 100;  // per scene

/// Runs a robot among such people in an empty hall, all drawn from that seed. `contacts` counts
/// only contacts while the robot moved.
[[nodiscard]] inline Tally run_people_scene(unsigned seed, bool watched = true) {
  Tally tally;
  Random random(seed);
  SafetyFilterParams params;
  params.people.watched = watched;
  params.survive_silence = pick(random, 2) == 0;
  const RobotParams robot = random_robot(random);
  Grid grid = free_grid(16.0, 0.1);
  add_border(grid);
  const auto map = as_map(std::move(grid));
  ClosedLoop loop(params, robot, random_base(random, params), robot, map, random);
  Hunters hunters(loop, random, params.people);
  loop.start_at({});
  loop.draw_pose_error(pick(random, 2) == 0);
  Adversary adversary(static_cast<Malice>(pick(random, kMalices)), robot, random);
  const bool chases = pick(random, 2) == 0;
  for (int i = 0; i < kPeopleTicks; ++i) {
    hunters.hunt();
    const Pose2 before = loop.sim().state().X_MB;
    const Twist2 command = chases ? at_nearest_person(loop.sim(), robot)
                                  : adversary.command(before, loop.sim().footprint(), *map);
    (void)loop.tick(command, params.control_period);
    tally.travel += (loop.sim().state().X_MB.position() - before.position()).norm();
  }
  if (params.survive_silence) loop.be_silent(1.0);
  tally.steps = kPeopleTicks;
  tally.rollouts = 1;
  tally.contacts = loop.sim().contacts().count;
  tally.walked_into = loop.sim().contacts().walked_into;
  if (tally.contacts > 0) tally.contact_seed = seed;
  return tally;
}

}  // namespace tandem::test
