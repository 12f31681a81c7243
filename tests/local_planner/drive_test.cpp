// SPDX-License-Identifier: Apache-2.0
// Tests the planner in closed loop with a robot that has delay and motor lag, without DDS.
#include "local_planner/drive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "local_planner/requests.hpp"
#include "tandem/local_planner/reference.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem::test {
namespace {

const Plant kAtStart{.X_MB = {-4, -4, 0}, .twist = {}, .delay = 0.02, .lag = 0.05};

NmpcParams lockstep() { return unlimited(); }

Drive drive(const NmpcParams& params, const Plant& plant, const std::vector<Obstacle>& obstacles,
            double seconds, const Person& person) {
  return drive(params, RobotParams{}, plant, obstacles, seconds, person);
}

Person to_goal(const Pose2& X_MG) {
  return [=](double, const Plant&, PlanRequest& request) {
    request.method = Method::kGoal;
    request.X_MG = X_MG;
  };
}

Person twist(double v, double w) {
  return [=](double, const Plant&, PlanRequest& request) {
    request.method = Method::kIntention;
    request.user = {v, w};
  };
}

double distance(const Drive& drive, double x, double y) {
  return std::hypot(drive.path.back().x - x, drive.path.back().y - y);
}

double share(int part, std::size_t whole) { return part / static_cast<double>(whole); }

// Devalla's tables 3.1 and 3.2 give 0.1283 and 0.1142. With the parameters as the thesis writes
// them the planner stops further away; with a terminal cost much closer.
struct Table {
  const char* title;
  bool poles;
  double terminal_weight;
  double steady_error;  // of this planner, recorded 2026-11-27, the same with each solver
};

constexpr double kRepeatable = 0.002;  // of steady_error

class ThesisTables : public testing::TestWithParam<Table> {};

TEST_P(ThesisTables, SteadyErrorIsTheRecordedOne) {
  const Table& table = GetParam();
  NmpcParams params = script_exact(table.poles);
  params.solver = unlimited().solver;
  params.terminal_weight = table.terminal_weight;
  const auto obstacles = table.poles ? forest(false) : std::vector<Obstacle>{};
  const Drive result =
      test::drive(params, RobotParams{}, {{-4, -4, 0}, {}}, obstacles, 30.0, to_goal({4, 4, 0}));
  const double theta = result.path.back().theta, d = distance(result, 4, 4);
  const double error = std::hypot(d, theta);
  std::printf("%s: steady error %.4f (distance %.4f m, heading %.4f rad)\n", table.title, error, d,
              theta);
  EXPECT_NEAR(error, table.steady_error, kRepeatable);
  EXPECT_EQ(result.contacts, 0);
  EXPECT_LE(share(result.fallbacks, result.plans.size()), 0.05);
}

INSTANTIATE_TEST_SUITE_P(
    Devalla2020, ThesisTables,
    testing::Values(Table{"table 3.1 as written", false, 0.0, 0.1737},
                    Table{"table 3.1 with a terminal cost", false, 50.0, 0.0374},
                    Table{"table 3.2 as written", true, 0.0, 0.1406},
                    Table{"table 3.2 with a terminal cost", true, 50.0, 0.0241}),
    [](const auto& table) { return std::string("Case") + std::to_string(table.index); });

TEST(Drive, GoalThroughTheForestIsReachedWithoutContact) {
  const Drive result = drive(lockstep(), kAtStart, forest(true), 30.0, to_goal({4.0, 2.5, 0.0}));
  EXPECT_EQ(result.contacts, 0);
  EXPECT_LE(share(result.fallbacks, result.plans.size()), 0.01);
  EXPECT_LT(distance(result, 4.0, 2.5), 0.1);
}

TEST(Drive, LeaderThroughTheForestIsFollowedWithoutContact) {
  const std::vector<Eigen::Vector2d> way{{-3, -3.4},  {-2.6, -2.9}, {0, -2.2},
                                         {2.2, -1.8}, {2.2, 0.5},   {4, 2.5}};
  const Drive result =
      drive(lockstep(), kAtStart, forest(true), 30.0, leader_along(way, 0.72, 1.2));
  EXPECT_EQ(result.contacts, 0);
  EXPECT_LE(share(result.fallbacks, result.plans.size()), 0.01);
  EXPECT_LE(result.worst_rate, 0.05 + 1e-9);  // acceleration limits hold between all commands
  EXPECT_LT(distance(result, 4.0, 2.5), 0.3);
}

// Drivers who do not see the obstacles: every method, random commands.
TEST(Drive, BlindPeopleInTheForestNeverTouchAndSeldomNeedAFallback) {
  int cycles = 0, fallbacks = 0;
  for (const Method method : {Method::kLeader, Method::kIntention, Method::kGoal})
    for (unsigned seed = 1; seed <= 2; ++seed) {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> place(-4.5, 4.5);
      double change = 0.0;
      Eigen::Vector2d p_MT{0, 0};
      const auto person = [&](double t, const Plant& plant, PlanRequest& request) {
        if (t >= change) p_MT = {place(random), place(random)}, change += 4.0;
        const Eigen::Vector2d to = p_MT - plant.X_MB.position();
        const double heading = std::atan2(to.y(), to.x());
        const Eigen::Vector2d ahead = plant.X_MB.position() + to * std::min(1.0, 1.2 / to.norm());
        request.method = method;
        request.X_MG = method == Method::kLeader ? Pose2{ahead.x(), ahead.y(), heading}
                                                 : Pose2{p_MT.x(), p_MT.y(), 0.0};
        request.user = {0.64, std::clamp(1.5 * wrap_angle(heading - plant.X_MB.theta), -0.8, 0.8)};
      };
      const Drive result = drive(lockstep(), kAtStart, forest(true), 15.0, person);
      EXPECT_EQ(result.contacts, 0) << name(method) << " seed " << seed;
      cycles += static_cast<int>(result.plans.size());
      fallbacks += result.fallbacks;
    }
  EXPECT_LE(share(fallbacks, static_cast<std::size_t>(cycles)), 0.01);
}

TEST(Drive, PersonWhoHeadsStraightForAPoleIsLedAroundIt) {
  const std::vector<Obstacle> pole{{1, {2.0, 0.0}, 0.225, 0.225, 0.0, {0, 0}}};
  const Drive result = drive(lockstep(), {{0, 0, 0}, {}, 0.02, 0.05}, pole, 12.0, twist(0.6, 0.0));
  EXPECT_EQ(result.contacts, 0);
  EXPECT_GT(result.path.back().x, 4.0);
}

TEST(Drive, LeaderBehindAWallOfPolesIsReachedByALocalDetour) {
  std::vector<Obstacle> poles;
  for (const double y : {-0.5, 0.0, 0.5})
    poles.push_back({static_cast<std::uint32_t>(2 * y + 2), {2.0, y}, 0.225, 0.225, 0.0, {0, 0}});
  const auto leader = [](double, const Plant& plant, PlanRequest& request) {
    const Eigen::Vector2d to = Eigen::Vector2d{5.0, 0.0} - plant.X_MB.position();
    const Eigen::Vector2d p = plant.X_MB.position() + to * std::min(1.0, 1.2 / to.norm());
    request.X_MG = {p.x(), p.y(), 0.0};
  };
  const Drive result = drive(lockstep(), {{0, 0, 0}, {}, 0.02, 0.05}, poles, 30.0, leader);
  EXPECT_EQ(result.contacts, 0);
  EXPECT_LT(distance(result, 5.0, 0.0), 0.2);
}

TEST(Drive, WaitsCalmlyAtAWallWithoutAWayAround) {
  const std::vector<Obstacle> wall{{1, {2, 0}, 4.0, 0.1, std::numbers::pi / 2, {0, 0}}};
  for (const double v : {0.6, 0.8}) {
    const Drive result = drive(lockstep(), {{0, 0, 0}, {}, 0.02, 0.05}, wall, 12.0, twist(v, 0.0));
    EXPECT_EQ(result.contacts, 0);
    EXPECT_GT(result.path.back().x, 0.8);
    EXPECT_LT(std::abs(result.plans.back().command.v), 0.05);
  }
}

TEST(Drive, WaitsCalmlyForALeaderBehindAWallWithoutAWayAround) {
  const std::vector<Obstacle> wall{{1, {2, 0}, 4.0, 0.1, std::numbers::pi / 2, {0, 0}}};
  for (const Method method : {Method::kLeader, Method::kPath}) {
    const auto leader = [&](double t, const Plant&, PlanRequest& request) {
      request.method = method;
      request.X_MG = {std::min(0.5 * t, 3.0), 0.3, 0.0};
    };
    const Drive result = drive(lockstep(), {{0, 0, 0}, {}, 0.02, 0.05}, wall, 16.0, leader);
    EXPECT_EQ(result.contacts, 0);
    EXPECT_GT(result.path.back().x, 0.8);
    double way = 0.0;
    for (std::size_t i = result.path.size() - 80; i < result.path.size(); ++i)
      way += (result.path[i].position() - result.path[i - 1].position()).norm();
    EXPECT_LT(way, 0.1) << name(method);  // in the last four seconds
  }
}

TEST(Drive, CorridorAHandsBreadthWiderThanTheRobotIsPassed) {
  std::vector<Obstacle> walls;
  for (const double side : {-1.0, 1.0})
    walls.push_back(
        {static_cast<std::uint32_t>(side + 2), {3.0, 0.48 * side}, 3.0, 0.1, 0.0, {0, 0}});
  for (const Person& person : {twist(0.6, 0.0), to_goal({6.0, 0.0, 0.0})}) {
    const Drive result = drive(lockstep(), {{0, 0, 0}, {}, 0.02, 0.05}, walls, 20.0, person);
    EXPECT_EQ(result.contacts, 0);
    EXPECT_GT(result.path.back().x, 5.5);
  }
}

// Share of cycles in which the person gets the commanded motion, within the limits of acceleration
// and braking, to within 1 % of the robot's range.
double agreement(const Drive& drive, const std::vector<Twist2>& asked, std::size_t first = 0) {
  const RobotParams robot;
  Twist2 before = first > 0 ? drive.plans[first - 1].command : Twist2{};
  int agreed = 0;
  for (std::size_t i = first; i < drive.plans.size(); ++i) {
    const Twist2& command = drive.plans[i].command;
    const PlanRequest stick{.method = Method::kIntention, .command = before, .user = asked[i]};
    const double v = approach(before.v, asked[i].v, robot.a_max, braking_of(stick, robot), 0.05);
    const double w = approach(before.w, asked[i].w, robot.alpha_max * 0.05);
    agreed +=
        std::abs(command.v - v) < 0.01 * robot.v_max && std::abs(command.w - w) < 0.01 * robot.w_max
            ? 1
            : 0;
    before = command;
  }
  return share(agreed, drive.plans.size() - first);
}

TEST(Intention, WithoutObstaclesThePersonDrivesThemselves) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> v(-0.4, 0.8), w(-1.0, 1.0);
    std::vector<Twist2> asked;
    Twist2 wanted;
    double change = 0.0;
    const auto person = [&](double t, const Plant&, PlanRequest& request) {
      if (t >= change) wanted = {v(random), w(random)}, change += 1.5;
      request.method = Method::kIntention;
      request.user = wanted;
      asked.push_back(wanted);
    };
    const Drive result = drive(lockstep(), kAtStart, {}, 15.0, person);
    EXPECT_GE(agreement(result, asked), 0.99) << "seed " << seed;
  }
}

TEST(Intention, GivesWayToAPoleSmoothlyAndComesBack) {
  const std::vector<Obstacle> beside{{1, {3.0, 0.35}, 0.225, 0.225, 0.0, {0, 0}}};
  const Plant plant{{0, 0, 0}, {}, 0.02, 0.05};
  const Drive result = drive(lockstep(), plant, beside, 10.0, twist(0.6, 0.0));
  EXPECT_EQ(result.contacts, 0);
  EXPECT_EQ(result.fallbacks, 0);
  EXPECT_LE(result.worst_rate, 0.05 + 1e-9);
  EXPECT_GT(result.path.back().x, 5.0);
  double aside = 0.0;
  int reversals = 0;  // of the turn, beyond a twentieth of the fastest
  double turn = 0.0;
  for (std::size_t i = 0; i < result.plans.size(); ++i) {
    aside = std::max(aside, std::abs(result.path[i].y));
    const double w = result.plans[i].command.w;
    if (std::abs(w) < 0.05) continue;
    reversals += turn * w < 0.0 ? 1 : 0;
    turn = w;
  }
  EXPECT_GT(aside, 0.1) << "the pole stands in the way, else this proves nothing";
  EXPECT_LE(reversals, 2);  // aside, along, back
  const std::vector<Twist2> asked(result.plans.size(), Twist2{0.6, 0.0});
  EXPECT_GE(agreement(result, asked, result.plans.size() - 40), 0.99);
}

// 0.80 m between two poles: room for the robot, 0.58 m wide, not for the circle of 0.45 m that
// Devalla 2020 plans with and that got stuck there (§5.1).
TEST(Drive, GapThatACircleCannotPassIsPassedByTheOutline) {
  const std::vector<Obstacle> poles{{1, {2.5, 0.625}, 0.225, 0.225, 0.0, {0, 0}},
                                    {2, {2.5, -0.625}, 0.225, 0.225, 0.0, {0, 0}},
                                    {3, {2.5, 2.6}, 1.6, 0.2, std::numbers::pi / 2, {0, 0}},
                                    {4, {2.5, -2.6}, 1.6, 0.2, std::numbers::pi / 2, {0, 0}}};
  const Plant plant{{0, 0, 0}, {}, 0.02, 0.05};
  NmpcParams circle = lockstep();
  circle.disc_radius = 0.45;
  for (const Person& person : {twist(0.6, 0.0), to_goal({5.0, 0.0, 0.0})}) {
    const Drive stuck = drive(circle, plant, poles, 15.0, person);
    EXPECT_LT(stuck.path.back().x, 2.5);
    const Drive result = drive(lockstep(), plant, poles, 15.0, person);
    EXPECT_EQ(result.contacts, 0);
    EXPECT_GT(result.path.back().x, 3.5);
  }
}

// A leader that drives round a pole: the robot follows its trail, not the straight line to it.
TEST(Drive, TrailOfTheLeaderIsFollowed) {
  double error = 0.0;
  const auto person = [&](double t, const Plant& plant, PlanRequest& request) {
    const double s = std::min(0.5 * t, 5.0);  // along a quarter of a circle, then straight
    const double turned = std::min(s / 1.5, std::numbers::pi / 2);
    const double rest = std::max(0.0, s - 1.5 * std::numbers::pi / 2);
    request.method = Method::kPath;
    request.X_MG = {1.5 * std::sin(turned), 1.5 * (1.0 - std::cos(turned)) + rest, turned};
    const double r = std::hypot(plant.X_MB.x, plant.X_MB.y - 1.5);
    if (plant.X_MB.y < 1.5) error = std::max(error, std::abs(r - 1.5));
  };
  const Drive result = drive(lockstep(), {{0, 0, 0}, {}, 0.02, 0.05}, {}, 16.0, person);
  EXPECT_LT(error, 0.15);
  EXPECT_LT(distance(result, 1.5, 1.5 + 5.0 - 1.5 * std::numbers::pi / 2), 0.15);
}

TEST(Drive, LeaderBehindAndBesideIsReached) {
  for (const Eigen::Vector2d& p : {Eigen::Vector2d{-1.0, 0.1}, Eigen::Vector2d{0.0, 1.0}}) {
    const auto leader = [&](double, const Plant&, PlanRequest& request) {
      request.X_MG = {p.x(), p.y(), 0.0};
    };
    const Drive result = drive(lockstep(), {{0, 0, 0}, {}, 0.02, 0.05}, {}, 20.0, leader);
    EXPECT_LT(distance(result, p.x(), p.y()), 0.2);
  }
}

// A person who pushes straight ahead, 0.3 m beside a lane along x, and then turns off it.
double beside_lane(double strength, double seconds, double turn) {
  static const std::vector<Eigen::Vector2d> along{{-10.0, 0.0}, {20.0, 0.0}};
  const std::vector<GuidanceLine> lane{{"lane", along, 0.8, strength}};
  const Person ahead = twist(0.5, turn);
  const Drive result = drive(lockstep(), {{0.0, 0.3, 0.0}, {}}, {}, seconds,
                             [&](double t, const Plant& plant, PlanRequest& request) {
                               ahead(t, plant, request);
                               request.guidance = lane;
                             });
  return result.path.back().y;
}

TEST(GuidanceLines, DrawInAPersonWhoComesNear) {
  EXPECT_NEAR(beside_lane(0.0, 10.0, 0.0), 0.3, 1e-6);
  const double drawn = std::abs(beside_lane(0.5, 10.0, 0.0));
  EXPECT_LT(drawn, 0.1);
}

TEST(GuidanceLines, HoldNobodyWhoTurnsOff) { EXPECT_GT(beside_lane(0.5, 6.0, 0.4), 1.0); }

// Mean distance of the robot from where each plan saw it half a second later [m].
double surprise(const Drive& drive, const NmpcParams& params) {
  const auto later = static_cast<std::size_t>(std::lround(0.5 / params.control_period));
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + later < drive.plans.size(); ++i, ++count) {
    const double t = params.control_period * static_cast<double>(i + later + 1);
    sum += (drive.plans[i].pose_at(t).position() - drive.path[i + later].position()).norm();
  }
  return sum / static_cast<double>(count);
}

// Motors with a lag of 0.4 s: a planner that models the lag predicts the robot's motion better than
// one that ignores it or treats it as a delay.
TEST(MotorLag, ToldToThePlannerIsForeseen) {
  const std::vector<Eigen::Vector2d> way{{-3, -3.4},  {-2.6, -2.9}, {0, -2.2},
                                         {2.2, -1.8}, {2.2, 0.5},   {4, 2.5}};
  const Plant slow{.X_MB = {-4, -4, 0}, .twist = {}, .delay = 0.02, .lag = 0.4};
  NmpcParams told = lockstep(), untold = lockstep(), delayed = lockstep();
  told.lag_v = told.lag_w = slow.lag;
  told.delay = untold.delay = 0.02;
  delayed.delay = slow.delay + slow.lag;
  const auto driven = [&](const NmpcParams& params) {
    const Drive result = drive(params, slow, forest(true), 30.0, leader_along(way, 0.72, 1.2));
    std::printf("lag %.1f s, delay %.2f s: off by %.3f m, %d contacts, %d fallbacks\n",
                params.lag_v, params.delay, surprise(result, params), result.contacts,
                result.fallbacks);
    return result;
  };
  const Drive result = driven(told);
  EXPECT_EQ(result.contacts, 0);
  EXPECT_LE(share(result.fallbacks, result.plans.size()), 0.01);
  EXPECT_LE(result.worst_rate, 0.05 + 1e-9);
  EXPECT_LT(distance(result, 4.0, 2.5), 0.3);
  const Drive unaware = driven(untold);
  EXPECT_GT(unaware.contacts, 0) << "the lag matters, else this proves nothing";
  EXPECT_LT(surprise(result, told), 0.5 * surprise(unaware, untold));
  EXPECT_LT(surprise(result, told), 0.6 * surprise(driven(delayed), delayed));
}

TEST(MeasuredDelay, IsWhatTheLoopHas) {
  NmpcParams params = lockstep();
  params.measure_delay = true;
  const Plant slow{.X_MB = {-4, -4, 0}, .twist = {}, .delay = 0.25, .lag = 0.05};
  const auto person = [](double t, const Plant&, PlanRequest& request) {
    request.method = Method::kIntention;
    request.user = {0.4 + 0.3 * std::sin(t), 0.6 * std::sin(1.7 * t)};
  };
  const Drive result = test::drive(params, RobotParams{}, slow, {}, 20.0, person);
  const double last = params.control_period * static_cast<double>(result.plans.size() - 1);
  EXPECT_NEAR(result.plans.back().t0 - last, 0.30, 0.03);
}

}  // namespace
}  // namespace tandem::test
