// SPDX-License-Identifier: Apache-2.0
// Tests how the filter drives among people.
#include <gtest/gtest.h>

#include <optional>
#include <utility>
#include <vector>

#include "safety_filter/filtering.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

class BesidePeople : public ::testing::Test {
 protected:
  BesidePeople() {
    params_.people.watched = true;
    filter_.emplace(filter_on(as_map(free_grid(20.0)), params_));
  }
  // A person whose outline is `gap` ahead of the bumper of a robot at the origin.
  static Obstacle ahead(double gap, double vx = 0.0) {
    return {.p_MO = {kBumper + gap + 0.25, 0.0}, .a = 0.25, .b = 0.25, .v_MO = {vx, 0.0}};
  }
  Filtered drive(const Twist2& command, std::vector<Obstacle> people, const Twist2& measured = {}) {
    filter_->on_people(std::move(people), 0.0);
    filter_->on_command(command, 0.0);
    return filter_->update(at(0.0, 0.0, 0.0, measured), 0.0);
  }

  SafetyFilterParams params_;
  std::optional<SafetyFilter> filter_;
};

TEST_F(BesidePeople, StandsUntilPeopleArriveAndWhenTheyFallSilent) {
  filter_->on_command({0.8, 0.0}, 0.0);
  EXPECT_EQ(filter_->update(at(0.0), 0.0).reason, FilterReason::kNoPeople);
  // an empty list is not a missing list
  EXPECT_EQ(drive({0.8, 0.0}, {}).twist, (Twist2{0.8, 0.0}));
  const double late = params_.people.people_timeout + 0.01;
  filter_->on_command({0.8, 0.0}, late);
  RobotState state = at(0.0);
  state.t = late;
  const Filtered out = filter_->update(state, late);
  EXPECT_EQ(out.reason, FilterReason::kNoPeople);
  EXPECT_EQ(out.twist, Twist2{});
}

TEST_F(BesidePeople, SlowsForNearPeopleAndNotForDistantOnes) {
  double last = 0.0;
  for (const double gap : {0.1, 0.3, 0.6, 1.0, 4.0}) {
    const Filtered out = drive({0.8, 0.0}, {ahead(gap)});
    EXPECT_GE(out.twist.v, last) << gap;
    last = out.twist.v;
  }
  EXPECT_EQ(last, 0.8);
  EXPECT_LT(drive({0.8, 0.0}, {ahead(0.3)}).twist.v, 0.2);
}

TEST_F(BesidePeople, AccountsForWhereTheyAreGoing) {
  const double leaves = drive({0.8, 0.0}, {ahead(0.8, 1.0)}).twist.v;
  const double comes = drive({0.8, 0.0}, {ahead(0.8, -1.0)}).twist.v;
  EXPECT_GT(leaves, comes + 0.2);
  EXPECT_LE(comes, params_.people.creep_speed);
}

TEST_F(BesidePeople, CreepsAwayFromAPersonInContactAndNotIntoThem) {
  const Filtered away = drive({-0.4, 0.0}, {ahead(0.01)});
  EXPECT_LT(away.twist.v, 0.0);
  EXPECT_GE(away.twist.v, -params_.people.creep_speed);
  EXPECT_EQ(drive({0.4, 0.0}, {ahead(0.01)}).twist, Twist2{});
}

TEST(SafetyFilter, WatchingNobodyChangesNoCommand) {
  Random random(1);
  SafetyFilterParams watching;
  watching.people.watched = true;
  for (unsigned i = 0; i < samples(300, 50); ++i) {
    const auto map = random_map(random);
    SafetyFilter plain = filter_on(map), watchful = filter_on(map, watching);
    watchful.on_people({}, 0.0);
    const RobotState state = at(uniform(random, -2.0, 2.0), uniform(random, -2.0, 2.0),
                                uniform(random, -3.0, 3.0), {uniform(random, -0.4, 0.8), 0.3});
    const Twist2 command{uniform(random, -0.4, 0.8), uniform(random, -1.0, 1.0)};
    plain.on_command(command, 0.0);
    watchful.on_command(command, 0.0);
    EXPECT_EQ(plain.update(state, 0.0).twist, watchful.update(state, 0.0).twist);
  }
}

}  // namespace
}  // namespace tandem::test
