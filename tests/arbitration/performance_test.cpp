// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/performance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tandem/arbitration/arbiter.hpp"

namespace tandem {
namespace {

constexpr double kPeriod = 0.05;

// An adaptive arbiter, far from everything.
class Adaptive {
 public:
  explicit Adaptive(const AdaptiveParams& params = {})
      : arbiter_{{.policy = "adaptive", .handover_time = 0.0, .adaptive = params}} {}

  Decision step(const Twist2& user, const Twist2& shared) {
    t_ += kPeriod;
    arbiter_.on_clearance(5.0, t_);
    arbiter_.on_user(user, t_);
    arbiter_.on_shared(shared, t_);
    return arbiter_.decide(t_);
  }
  Decision steps(const Twist2& user, const Twist2& shared, double duration) {
    Decision last;
    for (double t = 0.0; t < duration; t += kPeriod) last = step(user, shared);
    return last;
  }
  Arbiter& arbiter() { return arbiter_; }
  [[nodiscard]] double now() const { return t_; }

 private:
  Arbiter arbiter_;
  double t_ = 1.0;
};

TEST(Adaptive, GivesAGoodDriverTheMostAuthorityAndABadOneTheLeast) {
  Adaptive it;
  EXPECT_NEAR(it.steps({0.5, 0.1}, {0.5, 0.1}, 10.0).alpha, 0.3, 1e-9);
  EXPECT_NEAR(it.step({0.5, 0.1}, {0.5, 0.1}).performance, 1.0, 1e-9);
  const Decision bad = it.steps({0.5, 0.1}, {0.1, -0.6}, 30.0);
  EXPECT_GT(bad.alpha, 0.89);
  EXPECT_LT(bad.performance, 0.01);
  EXPECT_LT(it.steps({0.5, 0.1}, {0.5, 0.1}, 30.0).alpha, 0.41);  // and gives it back
}

TEST(Adaptive, AnUnsteadyHandRatesAsABadDriverEvenInTheRightDirection) {
  Adaptive steady, shaking;
  for (int i = 0; i < 400; ++i) {
    const double shake = i % 2 ? 0.15 : -0.15;
    (void)steady.step({0.5, 0.0}, {0.5, 0.0});
    (void)shaking.step({0.5, shake}, {0.5, 0.0});
  }
  EXPECT_GT(shaking.step({0.5, 0.0}, {0.5, 0.0}).alpha,
            steady.step({0.5, 0.0}, {0.5, 0.0}).alpha + 0.4);
}

TEST(Adaptive, StaysUntilItWouldChangeByMoreThanItsHysteresis) {
  Adaptive it;
  const double before = it.steps({0.5, 0.0}, {0.5, 0.0}, 5.0).alpha;
  const Decision little = it.steps({0.5, 0.0}, {0.45, 0.0}, 20.0);  // a tenth of a disagreement
  EXPECT_LT(little.performance, 0.91);
  EXPECT_EQ(little.alpha, before);
  EXPECT_GT(it.steps({0.5, 0.0}, {0.3, 0.0}, 20.0).alpha, before + 0.1);
}

TEST(Adaptive, DoesNotRateAPersonWhoAsksForNothing) {
  Adaptive it;
  EXPECT_EQ(it.steps({0.0, 0.0}, {0.4, 0.5}, 20.0).performance, 1.0);
}

TEST(Adaptive, DangerGivesThePlannerFullAuthority) {
  Adaptive it;
  (void)it.steps({0.5, 0.0}, {0.5, 0.0}, 1.0);
  Decision out;
  for (double t = it.now(); t < it.now() + 1.0; t += kPeriod) {
    it.arbiter().on_clearance(0.0, t);
    it.arbiter().on_user({0.5, 0.0}, t);
    it.arbiter().on_shared({0.2, 0.0}, t);
    out = it.arbiter().decide(t);
  }
  EXPECT_NEAR(out.alpha, 1.0, 1e-9);
}

TEST(Adaptive, StaysWithinItsBoundsWhateverIsCommanded) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> any(-2.0, 2.0);
  for (const AdaptiveParams& params :
       {AdaptiveParams{}, AdaptiveParams{.base = 0.2, .range = 0.4}}) {
    Adaptive it{params};
    double last = params.base;
    for (int i = 0; i < 20000; ++i) {
      const double v = i % 50 ? any(random) : std::numeric_limits<double>::quiet_NaN();
      const Decision out = it.step({v, any(random)}, {any(random), any(random)});
      ASSERT_GE(out.performance, 0.0);
      ASSERT_LE(out.performance, 1.0);
      if (out.source != Source::kBlend) continue;
      ASSERT_LE(out.alpha, std::min(1.0, params.base + params.range) + 1e-12);
      if (i < 20) continue;  // it comes from 0 at the start
      ASSERT_GE(out.alpha, params.base - 1e-12);
      ASSERT_LE(std::abs(out.alpha - last), 4.0 * 2.0 * kPeriod + 1e-9);  // blend_rate
      last = out.alpha;
    }
  }
}

}  // namespace
}  // namespace tandem
