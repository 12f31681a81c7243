// SPDX-License-Identifier: Apache-2.0
// The filter's promise, by at least 10⁵ closed-loop rollouts to standstill: no contact, whoever
// commands and however bad the base is within its bounds.
#include <gtest/gtest.h>

#include <algorithm>

#include "adversary.hpp"

namespace tandem::test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kRollouts = 3'000;
#else
constexpr int kRollouts = 100'000;
#endif
constexpr int kRolloutsPerScene = 20;
constexpr int kRolloutsPerStart = 4;  // then from somewhere else, to get up speed again

struct Tally {
  int rollouts = 0;
  unsigned contacts = 0;
  int unfinished = 0;  // did not come to rest
  double min_clearance = 1.0;
  double travel = 0.0;
};

// Full-speed malice for some ticks, then no command, or no filter, until the robot stands.
void roll_out(ClosedLoop& loop, Malice malice, const RobotParams& robot, const StaticMap& map,
              Random& random, Tally& tally) {
  const double control_period = loop.filter().params().control_period;
  Adversary adversary(malice, robot, random);
  loop.draw_pose_error(pick(random, 2) == 0);
  const int ticks = 6 + pick(random, 14);
  for (int i = 0; i < ticks; ++i) {
    const Pose2 before = loop.sim().state().X_MB;
    const double period = pick(random, 2) ? control_period : uniform(random, 0.02, control_period);
    (void)loop.tick(adversary.command(before, loop.sim().footprint(), map), period);
    tally.travel += (loop.sim().state().X_MB.position() - before.position()).norm();
  }
  if (loop.filter().params().survive_silence && pick(random, 2)) loop.be_silent(1.0);
  int waited = 0;
  for (; waited < 100 && (waited < 3 || !loop.stands()); ++waited)
    (void)loop.tick({}, control_period);
  ++tally.rollouts;
  tally.unfinished += loop.stands() ? 0 : 1;
}

void run_scene(unsigned seed, Tally& tally) {
  Random random(seed);
  SafetyFilterParams params;
  params.survive_silence = pick(random, 2) == 0;
  const RobotParams robot = random_robot(random);
  const auto map = random_map(random, pick(random, 2) ? 0.05 : 0.1);
  ClosedLoop loop(params, robot, random_base(random, params), map, random);
  unsigned contacts = 0;
  for (int i = 0; i < kRolloutsPerScene; ++i) {
    if (i % kRolloutsPerStart == 0) {
      Pose2 start;
      if (!find_free_pose(random, *map, loop.sim().footprint(), 0.06, start)) return;
      loop.start_at(start);
    }
    roll_out(loop, static_cast<Malice>(pick(random, kMalices)), robot, *map, random, tally);
    tally.min_clearance = std::min(tally.min_clearance, loop.sim().min_clearance());
    if (i % kRolloutsPerStart == kRolloutsPerStart - 1) contacts += loop.sim().contacts().count;
  }
  if (contacts > 0) ADD_FAILURE() << contacts << " contacts in scene " << seed;
  tally.contacts += contacts;
}

TEST(SafetyFilter, NeverEndsInContactWhateverIsCommanded) {
  Tally tally;
  for (unsigned seed = 1; tally.rollouts < kRollouts && !HasFailure(); ++seed)
    run_scene(seed, tally);
  EXPECT_GE(tally.rollouts, HasFailure() ? 0 : kRollouts);
  EXPECT_EQ(tally.contacts, 0u);
  EXPECT_EQ(tally.unfinished, 0);
  EXPECT_GT(tally.travel / tally.rollouts, 0.02);  // [m] a filter that only stops proves nothing
  EXPECT_LT(tally.min_clearance, 0.03);            // [m] … and it was tried hard
  std::printf("%d rollouts, %.0f m, smallest clearance %.4f m\n", tally.rollouts, tally.travel,
              tally.min_clearance);
}

}  // namespace
}  // namespace tandem::test
