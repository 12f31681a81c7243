// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/people.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tandem/diff_drive_sim/diff_drive_sim.hpp"

namespace tandem {
namespace {

constexpr double kDt = 0.01;  // [s]
const RobotParams kRobot{};

TEST(People, AreTheSameAfterBeingWrittenAsNumbers) {
  const std::vector<Walker> walkers{{0.25, 1.2, {{1.0, 2.0}, {-3.0, 4.5}}},
                                    {0.3, 0.0, {{5.0, 6.0}}}};
  const auto read = walkers_of(to_numbers(walkers));
  ASSERT_EQ(read.size(), walkers.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].radius, walkers[i].radius);
    EXPECT_EQ(read[i].speed, walkers[i].speed);
    EXPECT_EQ(read[i].p_MW, walkers[i].p_MW);
  }
}

TEST(People, RefuseNumbersOfAnotherForm) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<double>& bad : {std::vector<double>{0.25},
                                         {0.25, 1.0, 0.0, 1.0, 1.0},
                                         {0.25, 1.0, 2.0, 1.0, 1.0},
                                         {0.25, 1.0, 1.5, 1.0, 1.0, 1.0},
                                         {0.25, 1.0, kNaN, 1.0, 1.0},
                                         {0.25, 1.0, 1e300, 1.0, 1.0},
                                         {0.0, 1.0, 1.0, 1.0, 1.0},
                                         {0.25, -1.0, 1.0, 1.0, 1.0}})
    EXPECT_THROW((void)walkers_of(bad), std::invalid_argument);
}

// Near both ends of the way and in between, never above the bounds of speed and acceleration.
TEST(People, WalkToAndFroWithinTheirBounds) {
  People people({{0.25, 1.2, {{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}}}}, 0.8);
  EXPECT_EQ(people.all()[0].v_MO, Eigen::Vector2d(1.2, 0.0));  // from the start on
  int turns = 0;
  bool away = false;
  for (double t = 0.0; t < 60.0; t += kDt) {
    const Obstacle before = people.all()[0];
    people.advance(kDt);
    const Obstacle& now = people.all()[0];
    EXPECT_LE(now.v_MO.norm(), 1.2 + 1e-9);
    EXPECT_LE((now.v_MO - before.v_MO).norm(), 0.8 * kDt + 1e-9);
    EXPECT_LE((now.p_MO - before.p_MO).norm(), 1.2 * kDt + 1e-9);
    const Eigen::Vector2d end = away ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(4.0, 3.0);
    if ((now.p_MO - end).norm() > People::kArrived) continue;
    away = !away;
    ++turns;
  }
  EXPECT_GE(turns, 4);
  people.restart();
  EXPECT_EQ(people.all()[0].p_MO, Eigen::Vector2d(0.0, 0.0));
}

TEST(People, AreSeenByARayWhereTheyStand) {
  const People people({{0.5, 1.0, {{3.0, 0.0}}}, {0.5, 1.0, {{5.0, 0.2}}}}, 1.0);
  EXPECT_DOUBLE_EQ(people.cast_ray({0.0, 0.0}, 0.0, 10.0), 2.5);
  EXPECT_NEAR(people.cast_ray({0.0, 0.3}, 0.0, 10.0), 2.6, 1e-12);  // 3, 4, 5 of a chord
  EXPECT_EQ(people.cast_ray({0.0, 0.0}, 0.0, 2.0), 2.0);
  EXPECT_EQ(people.cast_ray({0.0, 0.0}, 3.0, 10.0), 10.0);  // behind
  EXPECT_NEAR(people.cast_ray({6.0, 0.2}, std::numbers::pi, 10.0), 0.5, 1e-12);
  EXPECT_EQ(people.cast_ray({3.1, 0.0}, 1.0, 10.0), 0.0);  // within
  EXPECT_EQ(People().cast_ray({0.0, 0.0}, 0.0, 10.0), 10.0);
}

TEST(People, WithOnePointStand) {
  People people({{0.25, 1.2, {{1.0, 2.0}}}}, 0.8);
  for (int i = 0; i < 100; ++i) people.advance(kDt);
  EXPECT_EQ(people.all()[0].p_MO, Eigen::Vector2d(1.0, 2.0));
}

TEST(People, CrossBySeedAndStartAwayFromTheRobot) {
  const Crossings crossings{
      .count = 12, .low = {-2.0, -1.0}, .high = {2.0, 1.0}, .slowest = 0.4, .fastest = 0.9};
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto walkers = crossing_people(crossings, seed, {-2.0, 0.0});
    ASSERT_EQ(walkers.size(), 12U);
    EXPECT_EQ(to_numbers(walkers), to_numbers(crossing_people(crossings, seed, {-2.0, 0.0})));
    EXPECT_NE(to_numbers(walkers), to_numbers(crossing_people(crossings, seed + 1, {-2.0, 0.0})));
    for (const Walker& walker : walkers) {
      EXPECT_GT((walker.p_MW[0] - Eigen::Vector2d(-2.0, 0.0)).norm(), kStartGap);
      EXPECT_GE((walker.p_MW[1] - walker.p_MW[0]).norm(), 2.0);  // from side to side
      EXPECT_GE(walker.speed, 0.4);
      EXPECT_LE(walker.speed, 0.9);
    }
  }
}

class AmongPeople : public ::testing::Test {
 protected:
  AmongPeople() {
    Grid grid;
    grid.width = grid.height = 160;
    grid.origin = {-4.0, -4.0};
    grid.cells.assign(160 * 160, Cell::kFree);
    sim_.emplace(DiffDriveSimParams{}, kRobot, std::make_shared<const StaticMap>(std::move(grid)),
                 1);
  }
  void put(const Walker& walker) { sim_->put({{walker}, 1.0}); }
  void drive(double v, double duration) {
    for (const double end = sim_->state().t + duration; sim_->state().t < end - 1e-9;) {
      sim_->command({v, 0.0}, sim_->state().t);
      sim_->advance_to(sim_->state().t + 0.02);
    }
  }
  [[nodiscard]] const ContactReport& contacts() const { return sim_->contacts(); }

  std::optional<DiffDriveSim> sim_;
};

TEST_F(AmongPeople, DrivingIntoSomebodyIsACollision) {
  put({0.25, 0.0, {{1.5, 0.0}}});
  drive(0.8, 3.0);
  EXPECT_EQ(contacts().count, 1U);
  EXPECT_EQ(contacts().walked_into, 0U);
  EXPECT_GT(sim_->state().X_MB.x, 1.0);  // nobody blocks the way
  drive(0.8, 2.0);
  EXPECT_FALSE(contacts().in_contact);
}

TEST_F(AmongPeople, BeingWalkedIntoIsNotACollision) {
  put({0.25, 1.0, {{2.5, 0.0}, {-2.5, 0.0}}});
  drive(0.0, 5.0);
  EXPECT_EQ(contacts().count, 0U);
  EXPECT_EQ(contacts().walked_into, 1U);
  EXPECT_FALSE(contacts().in_contact);
}

TEST_F(AmongPeople, DrivingOffWhileTheyTouchIsACollisionToo) {
  put({0.25, 1.0, {{2.5, 0.0}, {-2.5, 0.0}}});
  drive(0.0, 2.0);
  ASSERT_TRUE(contacts().in_contact);
  drive(0.4, 0.5);
  EXPECT_EQ(contacts().count, 1U);
  EXPECT_EQ(contacts().walked_into, 1U);
}

TEST_F(AmongPeople, ResetPutsPeopleBackToo) {
  put({0.25, 1.0, {{2.5, 0.0}, {-2.5, 0.0}}});
  drive(0.0, 2.0);
  sim_->reset({}, 1);
  EXPECT_EQ(sim_->people().all()[0].p_MO, Eigen::Vector2d(2.5, 0.0));
  EXPECT_EQ(contacts().walked_into, 0U);
}

}  // namespace
}  // namespace tandem
