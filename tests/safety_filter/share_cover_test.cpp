// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/share_cover.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace tandem::test {
namespace {

Reach spread_of(double path, double turn) {
  Reach reach;
  reach.path_spread = path;
  reach.turn_spread = turn;
  return reach;
}

TEST(ShareCover, OneCheckIsEnoughWhereNothingIsNear) {
  int checks = 0;
  EXPECT_TRUE(all_motions_clear(spread_of(1.0, 1.0), 1.0, [&](const ShareCell& cell) {
    ++checks;
    return cell.half.v == 0.5 && cell.half.w == 0.5;
  }));
  EXPECT_EQ(checks, 1);
}

TEST(ShareCover, ChecksTheFourCornersWhereMotionsHardlyDiffer) {
  std::vector<Shares> seen;
  EXPECT_TRUE(all_motions_clear(spread_of(0.1, 0.05), 1.0, [&](const ShareCell& cell) {
    EXPECT_EQ(cell.half.v, 0.0);
    seen.push_back(cell.center);
    return true;
  }));
  EXPECT_EQ(seen.size(), 4u);
}

// Every motion that makes contact is within the gaps of a motion that is checked.
TEST(ShareCover, FindsEveryMotionThatTouchesToWithinTheGaps) {
  const double path = 1.5, turn = 1.1, lever = 1.3;
  for (double v = 0.02; v < 1.0; v += 0.07)
    for (double w = 0.02; w < 1.0; w += 0.07) {
      const auto is_clear = [&](const ShareCell& cell) {
        const double near_v = std::abs(cell.center.v - v) * path;
        const double near_w = std::abs(cell.center.w - w) * turn * lever;
        return near_v > kPathGap + cell.half.v * path ||
               near_w > kTurnGap + cell.half.w * turn * lever;
      };
      EXPECT_FALSE(all_motions_clear(spread_of(path, turn), lever, is_clear)) << v << ' ' << w;
    }
}

TEST(ShareCover, RefusesWhatWouldTakeTooManyChecks) {
  int checks = 0;
  EXPECT_FALSE(all_motions_clear(spread_of(100.0, 100.0), 10.0, [&](const ShareCell& cell) {
    ++checks;
    return cell.half.v == 0.0;  // no cell as a whole
  }));
  EXPECT_LE(checks, 400);
}

}  // namespace
}  // namespace tandem::test
