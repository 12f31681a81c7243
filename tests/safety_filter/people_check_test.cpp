// SPDX-License-Identifier: Apache-2.0
// Tests which motions the check lets pass beside people.
#include "tandem/safety_filter/people_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "safety_filter/scenes.hpp"

namespace tandem::test {
namespace {

constexpr double kPersonRadius = 0.25;
constexpr double kRounding = 0.01;  // [m] that the check may lose to its step in time

// People whose tracks are exact and who keep their velocity.
PeopleParams exact() {
  return {.watched = true,
          .people_delay = 0.0,
          .person_error = 0.0,
          .person_speed_error = 0.0,
          .person_speed = 0.0,
          .person_acceleration = 0.0};
}

const DriftBounds kDrift{.wheel_separation = kMir.wheel_separation};  // none

BoundedFootprint mir() {
  const Footprint outline = footprint_of(kMir);
  return {outline, circumradius(outline)};
}

// A person whose outline is `gap` ahead of the bumper of a robot at the origin.
Obstacle ahead(double gap, double vx = 0.0) {
  return {.p_MO = {kBumper + gap + kPersonRadius, 0.0},
          .a = kPersonRadius,
          .b = kPersonRadius,
          .v_MO = {vx, 0.0}};
}

// One second at this twist from the origin, then at rest; the list has just arrived.
bool passes(const PeopleParams& params, const Twist2& twist, const Obstacle& person,
            double level = 0.0) {
  const PeopleCheck check(params, kMir, mir());
  return check.keeps_away({{twist, twist, 1.0}}, {{0.5, 0.5}}, twist, Pose2{}, 0.0, {{person}, 0.0},
                          level, kDrift);
}

TEST(PeopleCheck, LetsAMotionEndBeforeAPersonWhoStandsStill) {
  EXPECT_TRUE(passes(exact(), {0.5, 0.0}, ahead(0.5 + kRounding)));
  EXPECT_FALSE(passes(exact(), {0.5, 0.0}, ahead(0.5 - kRounding)));
}

TEST(PeopleCheck, KeepsTheLevelToo) {
  EXPECT_TRUE(passes(exact(), {0.5, 0.0}, ahead(0.6 + kRounding), 0.1));
  EXPECT_FALSE(passes(exact(), {0.5, 0.0}, ahead(0.6 - kRounding), 0.1));
}

TEST(PeopleCheck, ExpectsPeopleToKeepTheirVelocity) {
  PeopleParams params = exact();
  params.person_speed = 1.0;  // so that they may also stand still or turn back
  EXPECT_TRUE(passes(params, {0.5, 0.0}, ahead(0.1, 1.0))) << "walks away";
  EXPECT_FALSE(passes(params, {0.5, 0.0}, ahead(1.4, -1.0))) << "comes nearer";
}

TEST(PeopleCheck, AllowsForTheAccelerationUpToTheHighestSpeed) {
  PeopleParams params = exact();
  params.person_speed = 1.6;
  params.person_acceleration = 1.5;  // ½ a t² = 0.75 m in the second, less than 1.6 m
  EXPECT_TRUE(passes(params, {0.5, 0.0}, ahead(0.5 + 0.75 + kRounding)));
  EXPECT_FALSE(passes(params, {0.5, 0.0}, ahead(0.5 + 0.75 - 2.0 * kRounding)));
  params.person_acceleration = 4.0;
  EXPECT_TRUE(passes(params, {0.5, 0.0}, ahead(0.5 + 1.6 + 2.0 * kRounding)));
  EXPECT_FALSE(passes(params, {0.5, 0.0}, ahead(0.5 + 1.6 - 2.0 * kRounding)));
}

TEST(PeopleCheck, AnOlderListNeedsMoreRoom) {
  PeopleParams params = exact();
  params.person_speed = 0.5;
  params.person_acceleration = 4.0;
  EXPECT_TRUE(passes(params, {0.5, 0.0}, ahead(1.05)));
  params.people_delay = 0.2;  // 0.1 m more
  EXPECT_FALSE(passes(params, {0.5, 0.0}, ahead(1.05)));
  EXPECT_TRUE(passes(params, {0.5, 0.0}, ahead(1.15)));
}

TEST(PeopleCheck, CreepsPastAPersonInReachButNotNearerToThem) {
  const double creep = 0.9 * exact().creep_speed;
  EXPECT_FALSE(passes(exact(), {creep, 0.0}, ahead(0.005), 0.03));
  EXPECT_TRUE(passes(exact(), {-creep, 0.0}, ahead(0.005), 0.03));
  EXPECT_TRUE(passes(exact(), {0.0, 0.0}, ahead(0.005), 0.03));
  EXPECT_FALSE(passes(exact(), {-0.5, 0.0}, ahead(-0.005), 0.03)) << "faster than it may creep";
}

TEST(PeopleCheck, AFarPersonNeedsNoDetailedCheck) {
  Random random(5);
  const PeopleParams params{.watched = true};
  const PeopleCheck check(params, kMir, mir());
  int far = 0, blocked = 0;
  for (int i = 0; i < 2000; ++i) {
    const Obstacle person{.p_MO = {uniform(random, -6.0, 6.0), uniform(random, -6.0, 6.0)},
                          .a = kPersonRadius,
                          .b = kPersonRadius,
                          .v_MO = {uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0)}};
    const Twist2 twist{uniform(random, -0.4, 0.8), uniform(random, -1.0, 1.0)};
    const double duration = uniform(random, 0.1, 1.0);
    const PeopleSeen people{{person}, -uniform(random, 0.0, 0.2)};
    const double way = (std::abs(twist.v) + mir().radius * std::abs(twist.w)) * duration;
    const bool passes = check.keeps_away({{twist, twist, duration}}, {{0.5, 0.5}}, twist, Pose2{},
                                         0.0, people, 0.0, kDrift);
    if (check.is_far(people, Pose2{}, way + 2.0 * kRounding, 0.0, duration)) {
      ++far;
      ASSERT_TRUE(passes) << i;
    }
    blocked += passes ? 0 : 1;
  }
  EXPECT_GT(far, 100);
  EXPECT_GT(blocked, 50);
}

// The motor's exponential tail: v falls from kTailSpeed to the speed at which it stands.
TEST(PeopleCheck, WaitsForTheTailOfASlowMotorOnlyIfItMayCreepMoreSlowly) {
  RobotParams slow = kMir;
  slow.motor_lag = 0.4;
  PeopleParams params = exact();
  EXPECT_EQ(PeopleCheck(params, slow, mir()).tail(), 0.0);
  params.creep_speed = 0.001;
  EXPECT_NEAR(PeopleCheck(params, slow, mir()).tail(), 0.4 * (std::log(0.01 / 0.0005) - 1.0),
              1e-12);
}

}  // namespace
}  // namespace tandem::test
