// SPDX-License-Identifier: Apache-2.0
// Tests how much of the planner's command the policy `blend` passes on.
#include <gtest/gtest.h>

#include "arbitration/arbiter.hpp"

namespace tandem {
namespace {

TEST(Arbiter, BlendsHugeCommandsToAFiniteOne) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  for (const char* policy : {"blend", "adaptive"}) {
    Arbiter it = arbiter(policy);
    for (double t = 1.0; t < 3.0; t += 0.05) {
      it.on_user({kHuge, -kHuge}, t);
      it.on_shared({-kHuge, kHuge}, t);
      it.on_clearance(t < 2.0 ? 5.0 : -kHuge, t);
      const Decision out = it.decide(t);
      ASSERT_TRUE(is_finite(out.command)) << policy << " at " << t;
      ASSERT_GE(out.alpha, 0.0);
      ASSERT_LE(out.alpha, 1.0);
      ASSERT_GE(out.performance, 0.0);
      ASSERT_LE(out.performance, 1.0);
    }
  }
}

TEST(Arbiter, BlendGivesThePlannerMoreNearObstacles) {
  Arbiter it = arbiter("blend");
  double far = 0.0, near = 0.0;
  for (double t = 1.0; t < 3.0; t += 0.05) {
    it.on_user({0.5, 0.0}, t);
    it.on_shared({0.45, 0.0}, t);
    it.on_clearance(5.0, t);
    far = it.decide(t).alpha;
  }
  for (double t = 3.0; t < 5.0; t += 0.05) {
    it.on_user({0.5, 0.0}, t);
    it.on_shared({0.45, 0.0}, t);
    it.on_clearance(0.0, t);
    near = it.decide(t).alpha;
  }
  EXPECT_NEAR(far, 0.1, 1e-9);
  EXPECT_NEAR(near, 1.0, 1e-9);
}

TEST(Arbiter, BlendChangesAuthorityNoFasterThanItsRate) {
  Arbiter it{{.policy = "blend", .handover_time = 0.0, .blend = {.rate = 2.0}}};
  double last = 0.0;
  for (double t = 1.0; t < 2.0; t += 0.05) {
    it.on_user({0.8, 0.0}, t);
    it.on_shared({-0.4, 1.0}, t);
    const double alpha = it.decide(t).alpha;
    if (t > 1.0) {
      EXPECT_LE(alpha - last, 2.0 * 0.05 + 1e-9);
    }
    last = alpha;
  }
  EXPECT_EQ(last, 1.0);
}

TEST(Arbiter, KeepsRunningAfterABlendParameterChange) {
  Arbiter it{{.policy = "blend", .handover_time = 0.0}};
  EXPECT_THROW(it.set_blend({.rate = 0.0}), std::invalid_argument);
  it.set_blend({.min = 0.3});
  double alpha = 0.0;
  for (double t = 1.0; t < 2.0; t += 0.05) {
    it.on_user({0.5, 0.0}, t);
    it.on_shared({0.5, 0.0}, t);
    it.on_clearance(9.0, t);
    alpha = it.decide(t).alpha;
  }
  EXPECT_NEAR(alpha, 0.3, 1e-9);
  EXPECT_EQ(it.policy(), Policy::kBlend);
}

}  // namespace
}  // namespace tandem
