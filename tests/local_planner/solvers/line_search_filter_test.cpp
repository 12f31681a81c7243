// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/line_search_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tandem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

LineSearchFilter filter_from(double infeasibility) {
  LineSearchFilter filter;
  filter.reset(infeasibility);
  return filter;
}

TEST(LineSearchFilter, AcceptsWhatIsBetterInOneMeasure) {
  const Merit now{1.0, 5.0};
  EXPECT_TRUE(filter_from(1.0).accepts(now, {0.5, 9.0}, 1.0, 0.0));
  EXPECT_TRUE(filter_from(1.0).accepts(now, {2.0, 4.0}, 1.0, 0.0));
  EXPECT_FALSE(filter_from(1.0).accepts(now, {1.1, 5.1}, 1.0, 0.0));
  EXPECT_FALSE(filter_from(1.0).accepts(now, now, 1.0, 0.0)) << "nothing gained";
}

TEST(LineSearchFilter, RefusesWhatIsNotANumberOrFarFromFeasible) {
  const Merit now{1.0, 5.0};
  EXPECT_FALSE(filter_from(1.0).accepts(now, {0.5, kNaN}, 1.0, 0.0));
  EXPECT_FALSE(filter_from(1.0).accepts(now, {kNaN, 1.0}, 1.0, 0.0));
  EXPECT_FALSE(
      filter_from(1.0).accepts(now, {0.5, -std::numeric_limits<double>::infinity()}, 1.0, 0.0));
  EXPECT_FALSE(filter_from(1.0).accepts(now, {1.1e4, 1.0}, 1.0, 0.0));
  EXPECT_TRUE(filter_from(10.0).accepts(now, {1.1e4, 1.0}, 1.0, 0.0)) << "as from so far away";
}

TEST(LineSearchFilter, AFeasiblePointMustGainAShareOfWhatTheSlopePromises) {
  const Merit now{0.0, 5.0};
  EXPECT_TRUE(filter_from(0.0).accepts(now, {1e-3, 4.0}, 1.0, -1.0));
  EXPECT_FALSE(filter_from(0.0).accepts(now, {0.0, 5.0}, 1.0, -1.0));
  EXPECT_FALSE(filter_from(0.0).accepts(now, {0.0, 5.0 - 1e-9}, 1.0, -1.0));
}

TEST(LineSearchFilter, ADescentFromAFeasiblePointLeavesNoEntry) {
  LineSearchFilter filter = filter_from(0.0);
  const Merit now{1e-6, 5.0};
  ASSERT_TRUE(filter.accepts(now, {1e-6, 4.0}, 1.0, -1.0));
  EXPECT_TRUE(filter.accepts({1e-3, 9.0}, {1e-5, 6.0}, 1.0, 0.0))
      << "worse than the first point in both measures";
}

// Without this an iteration could cycle: from a point that is left for feasibility's sake, no later
// point may come back.
TEST(LineSearchFilter, NoPointThatWasLeftIsReachedAgainBeforeTheFilterIsReset) {
  std::mt19937 random{3};
  std::uniform_real_distribution<double> unit{0.0, 1.0};
  int accepted = 0, refused_as_worse = 0;
  for (int run = 0; run < 300; ++run) {
    LineSearchFilter filter = filter_from(1.0);
    Merit now{1.0, 1.0};
    std::vector<Merit> left;
    for (int i = 0; i < 200; ++i) {
      const Merit trial{2.0 * unit(random), 4.0 * unit(random) - 2.0};
      bool is_worse = false;  // than a point that was left, in both measures
      for (const Merit& old : left)
        is_worse =
            is_worse || (trial.infeasibility >= old.infeasibility && trial.barrier >= old.barrier);
      const bool accepts = filter.accepts(now, trial, 1.0, 0.0);
      EXPECT_FALSE(accepts && is_worse) << "run " << run << ", trial " << i;
      refused_as_worse += is_worse ? 1 : 0;
      if (!accepts) continue;
      ++accepted;
      left.push_back(now);
      now = trial;
    }
    for (const Merit& old : left) EXPECT_FALSE(filter.accepts(now, old, 1.0, 0.0));
    filter.reset(1.0);
    EXPECT_TRUE(filter.accepts({2.0, 2.0}, {1.0, 1.0}, 1.0, 0.0));
  }
  EXPECT_GT(accepted, 1000);
  EXPECT_GT(refused_as_worse, 1000);
}

}  // namespace
}  // namespace tandem
