// SPDX-License-Identifier: Apache-2.0
// Checks the filter's guarantee in at least 20,000 control steps of closed-loop rollouts to
// standstill: no contact, whatever is commanded and whatever the base does within its bounds.
// `safety_filter_rollouts` runs the same check for any length of time.
#include "safety_filter/inside_rollouts.hpp"
#include "safety_filter/people_rollouts.hpp"

#include <gtest/gtest.h>

#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

const long kSteps = samples(20'000, 1'500, 150'000);
const unsigned kInsideScenes = samples(5, 1, 200);
const unsigned kPeopleScenes = samples(200, 10, 400);

TEST(SafetyFilter, NeverEndsInContactWhateverIsCommanded) {
  Tally tally;
  for (unsigned seed = 1; tally.steps < kSteps && tally.contacts == 0; ++seed)
    tally.add(run_scene(seed));
  EXPECT_EQ(tally.contacts, 0) << "in scene " << tally.contact_seed;
  EXPECT_EQ(tally.unfinished, 0);
  EXPECT_GT(tally.travel / static_cast<double>(tally.rollouts), 0.02);  // [m] it did not just stop
  EXPECT_LT(tally.min_clearance, 0.03);  // [m] … and came close to obstacles
  if (kInstrumented) std::printf("shortened: a sanitizer watches\n");
  std::printf("%ld steps, %ld rollouts, %.0f m, smallest clearance %.4f m\n", tally.steps,
              tally.rollouts, tally.travel, tally.min_clearance);
}

// A fork's corner beside a cell, in a pose that the noise turns by half a degree: the measured
// direction to the cell is ahead in one period and beside it in the next. A rule that believed it
// touched the cell here, once in 6.2 million steps.
TEST(SafetyFilter, NoiseOfThePoseBesideACornerEndsInNoContact) {
  EXPECT_EQ(run_scene(8'000'555).contacts, 0);
}

// That rule touched something in scene 46, and came within 4 mm in scene 48.
TEST(SafetyFilter, ComesNoNearerFromWithinTheMargin) {
  Tally tally;
  for (unsigned i = 0; i < kInsideScenes; ++i) tally.add(run_inside_scene(46 + i));
  EXPECT_EQ(tally.contacts, 0) << "in scene " << tally.contact_seed;
  EXPECT_GE(tally.min_clearance, least_rest({}) - 0.5 * kCheckSpacing)
      << "in scene " << tally.closest_seed;
  EXPECT_GT(tally.travel / static_cast<double>(tally.rollouts), 0.02);  // [m] some could leave
  std::printf("%ld steps, %ld rollouts, %.0f m, smallest clearance %.4f m\n", tally.steps,
              tally.rollouts, tally.travel, tally.min_clearance);
}

// Shows that the bounds matter: a base far beyond them hits something. Otherwise the rollouts above
// would prove nothing about the filter.
TEST(SafetyFilter, TouchesOnceTheBoundsAreFarFromTrue) {
  if (kInstrumented) GTEST_SKIP() << "asked of the scenes, which are the same without a sanitizer";
  for (const Beyond& beyond : {Beyond{.braking = 4.0}, Beyond{.delay = 6.0},
                               Beyond{.pose_error = 6.0}, Beyond{.slip = 20.0}}) {
    Tally tally;
    for (unsigned seed = 1; seed <= 300 && tally.contacts == 0; ++seed)
      tally.add(run_scene(seed, beyond));
    EXPECT_GT(tally.contacts, 0);
  }
}

// People may walk into the robot, but it must not touch anyone while it moves.
TEST(SafetyFilter, TouchesNobodyWhileItMovesItself) {
  Tally tally;
  for (unsigned seed = 1; seed <= kPeopleScenes && tally.contacts == 0; ++seed)
    tally.add(run_people_scene(seed));
  EXPECT_EQ(tally.contacts, 0) << "in scene " << tally.contact_seed;
  EXPECT_GT(tally.walked_into, kPeopleScenes / 10);                    // people did reach the robot
  EXPECT_GT(tally.travel / static_cast<double>(tally.rollouts), 0.3);  // [m] it did not just stand
  std::printf("%ld steps, %ld scenes, %.0f m, walked into %ld times\n", tally.steps, tally.rollouts,
              tally.travel, tally.walked_into);
}

// Otherwise the scenes would prove nothing.
TEST(SafetyFilter, TouchesPeopleIfItDoesNotWatchThem) {
  Tally tally;
  for (unsigned seed = 1; seed <= 20; ++seed) tally.add(run_people_scene(seed, false));
  EXPECT_GE(tally.contacts, 10);
}

}  // namespace
}  // namespace tandem::test
