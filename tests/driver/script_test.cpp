// SPDX-License-Identifier: Apache-2.0
// Tests scripts as text, and the simulated person who executes their phases.
#include "tandem/driver/script.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

namespace tandem {
namespace {

constexpr double kTick = 0.05;                       // [s] of the joystick
const Footprint kChair = rectangle(1.0, 0.65, 0.1);  // front 0.6, rear 0.4, sides 0.325

NavigatorParams with_noise(double noise) {
  NavigatorParams params;
  params.stick_noise = noise;
  return params;
}

const NavigatorParams kCalm = with_noise(0.0);

std::string complaint_of(const std::string& text) {
  try {
    (void)read_script(text, kChair);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

// A robot that executes the hand's commands, except for what `allowed` removes from the twist.
struct Drive {
  std::vector<Hand> hands;
  std::vector<Pose2> X_MB;
  bool ended = false;
};
using Allowed = std::function<Twist2(const Pose2&, const Twist2&)>;

Drive drive_script(const std::string& text, Pose2 X, double duration, unsigned seed = 1,
                   const NavigatorParams& params = kCalm, const Allowed& allowed = {}) {
  Script script{text, params, kChair, seed};
  Drive drive;
  for (long n = 0; kTick * static_cast<double>(n) < duration && !drive.ended; ++n) {
    const Hand hand = script.steer(X, X, kTick * static_cast<double>(n));
    drive.ended = script.arrived();
    Twist2 twist{0.8 * hand.linear, 0.8 * hand.angular};
    if (allowed) twist = allowed(X, twist);
    X = integrate(X, twist, kTick);
    drive.hands.push_back(hand);
    drive.X_MB.push_back(X);
  }
  return drive;
}

TEST(ScriptText, HasPathsTurnsHoldsAndPushes) {
  const auto phases = read_script(
      "path forward 0.8 to 0.1 within 0.02 for 12 leader via 0 0 1 0; turn 1.5 stick 0.3\n"
      "# a comment; of no effect\nhold 5 # and another\npush -1 0.5 2",
      kChair);
  ASSERT_EQ(phases.size(), 4U);
  const auto& path = std::get<PathPhase>(phases[0].action);
  EXPECT_EQ(path.direction, 1.0);
  EXPECT_EQ(path.stick, 0.8);
  EXPECT_EQ(path.end_stick, 0.1);
  EXPECT_EQ(path.tolerance, 0.02);
  EXPECT_TRUE(path.leader_arrives);
  EXPECT_EQ(phases[0].time, 12.0);
  EXPECT_EQ(std::get<TurnPhase>(phases[1].action).heading, 1.5);
  EXPECT_EQ(std::get<TurnPhase>(phases[1].action).stick, 0.3);
  EXPECT_EQ(std::get<PushPhase>(phases[2].action).linear, 0.0);
  EXPECT_EQ(phases[2].time, 5.0);
  EXPECT_EQ(std::get<PushPhase>(phases[3].action).angular, 0.5);
}

TEST(ScriptText, CountsFromTheEdgesOfTheOutline) {
  const auto phases = read_script("path back 0.5 via 4.0-0.07-front 1+left -rear 2-right", kChair);
  const auto& route = std::get<PathPhase>(phases[0].action).route;
  EXPECT_NEAR(route.point_at(0.0).x(), 3.33, 1e-12);
  EXPECT_NEAR(route.point_at(0.0).y(), 1.325, 1e-12);
  EXPECT_NEAR(route.point_at(route.length()).x(), -0.4, 1e-12);
  EXPECT_NEAR(route.point_at(route.length()).y(), 1.675, 1e-12);
}

TEST(ScriptText, ErrorsNameThePhase) {
  for (const char* wrong :
       {"jump 1", "hold", "hold -1", "hold 1 2", "hold nan", "push 0.5 0", "push 2 0 1",
        "path up 1 via 0 0 1 0", "path forward 0.5 0 0 1 0", "path forward 0.5 via 0 0",
        "path forward 0.5 via 0 0 1", "path forward 0.5 via 0 0 0 0",
        "path forward 0.5 via 0 0 x 0", "path forward 0.5 to via 0 0 1 0",
        "path forward 0.5 fast via 0 0 1 0", "turn", "turn 1 within", "turn 1 2",
        "path forward 0.5 via 1--1 0 1 0"}) {
    const std::string said = complaint_of(std::string{"hold 1; "} + wrong);
    EXPECT_TRUE(said.starts_with("script, phase 2: ")) << wrong << ": " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
  EXPECT_NE(complaint_of(""), "");
  EXPECT_NE(complaint_of(" \n; "), "");
}

TEST(Script, IsTheSameForTheSameSeed) {
  const std::string text = "path forward 0.8 via 0 0 2 0 3 1; turn 0; path back 0.5 via 3 1 1 1";
  const NavigatorParams noisy = with_noise(0.1);
  const auto a = drive_script(text, {}, 40.0, 3, noisy), b = drive_script(text, {}, 40.0, 3, noisy);
  EXPECT_TRUE(a.ended);
  EXPECT_EQ(a.X_MB, b.X_MB);
  EXPECT_NE(a.X_MB, drive_script(text, {}, 40.0, 4, noisy).X_MB);
}

TEST(Script, StopsWithTheFrontWhereItWasToldTo) {
  const auto drive =
      drive_script("path forward 0.8 to 0.1 within 0.02 via 0 0.3 1.5 0 3.93-front 0; hold 2",
                   {0.0, 0.3, 0.0}, 40.0);
  EXPECT_TRUE(drive.ended);
  EXPECT_NEAR(drive.X_MB.back().x, 3.33, 0.02);
  EXPECT_NEAR(drive.X_MB.back().y, 0.0, 0.02);
  EXPECT_NEAR(drive.X_MB.back().theta, 0.0, 0.05);
  EXPECT_FALSE(drive.hands.back().holds);
}

TEST(Script, DrivesBackwardWithTheRearAhead) {
  const auto drive = drive_script("path back 0.5 to 0.1 via 0 0 -1.5 0.2 -3 0.2", {}, 40.0);
  EXPECT_TRUE(drive.ended);
  EXPECT_NEAR(drive.X_MB.back().x, -3.0, 0.06);
  EXPECT_NEAR(drive.X_MB.back().y, 0.2, 0.04);
  for (const Hand& hand : drive.hands) EXPECT_LE(hand.linear, 0.0);
}

TEST(Script, TurnsOnTheSpotTheShortWayRound) {
  const auto drive = drive_script("turn -1.5708", {0.0, 0.0, 2.5}, 20.0);
  EXPECT_TRUE(drive.ended);
  EXPECT_NEAR(wrap_angle(drive.X_MB.back().theta + 1.5708), 0.0, 0.06);
  EXPECT_GT(drive.X_MB.back().theta, 2.5);
  EXPECT_EQ(drive.X_MB.back().x, 0.0);
}

TEST(Script, HoldsTheDeadManWithTheStickAtRest) {
  const auto drive = drive_script("hold 3; push -1 0.25 2", {}, 20.0);
  ASSERT_EQ(drive.hands.size(), 101U);  // five seconds, and the sample that lets go
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_TRUE(drive.hands[i].holds);
    EXPECT_EQ(drive.hands[i].linear, i < 60 ? 0.0 : -1.0) << i;
    EXPECT_EQ(drive.hands[i].angular, i < 60 ? 0.0 : 0.25) << i;
  }
  EXPECT_FALSE(drive.hands.back().holds);
}

TEST(Script, GoesOnToTheNextPhaseWhenOneTakesTooLong) {
  const auto stands = [](const Pose2&, const Twist2&) { return Twist2{}; };
  const auto drive =
      drive_script("path forward 0.5 for 4 via 0 0 2 0; turn 1 for 3", {}, 60.0, 1, kCalm, stands);
  EXPECT_TRUE(drive.ended);
  EXPECT_NEAR(static_cast<double>(drive.hands.size()) * kTick, 7.0, 0.11);
}

TEST(Script, PushesHarderWhenNothingMovesThenBacksOutAndTriesAgain) {
  const auto wall = [](const Pose2& X, const Twist2& twist) {
    return Twist2{X.x >= 1.0 ? std::min(0.0, twist.v) : twist.v, twist.w};
  };
  const auto drive = drive_script("path forward 0.5 for 15 via 0 0 3 0", {}, 60.0, 1, kCalm, wall);
  double most = 0.0, least = 0.0, last_high = 0.0, x_at_back_out = 0.0;
  for (std::size_t i = 0; i < drive.hands.size(); ++i) {
    most = std::max(most, drive.hands[i].linear);
    if (drive.hands[i].linear < least) x_at_back_out = drive.X_MB[i].x;
    least = std::min(least, drive.hands[i].linear);
    if (least < 0.0 && drive.hands[i].linear > 0.0)
      last_high = std::max(last_high, drive.X_MB[i].x);
  }
  EXPECT_GT(most, 0.8);    // harder than the script's 0.5
  EXPECT_LT(least, -0.4);  // backs out
  EXPECT_NEAR(x_at_back_out, 1.0, 0.05);
  EXPECT_NEAR(last_high, 1.0, 0.05);  // and comes again
}

// The robot stands, so the leader must not drive away from it.
TEST(Script, HoldsALeaderNoFartherAheadThanItLooks) {
  NavigatorParams params = kCalm;
  params.preview = 0.6;
  Script script{"path forward 0.8 via 0 0 4 0", params, kChair, 1};
  Pose2 X_ML{1e-6, 0.0, 0.0};
  double farthest = 0.0;
  for (double t = 0.0; t < 1.4; t += kTick) {
    const Hand hand = script.steer({}, X_ML, t);
    X_ML = integrate(X_ML, {0.9 * hand.linear, 0.9 * hand.angular}, kTick);
    farthest = std::max(farthest, X_ML.x);
  }
  EXPECT_GT(farthest, 0.4);
  EXPECT_LT(farthest, 0.7);
}

TEST(Script, MayEndAPathWhenTheLeaderIsThere) {
  for (const bool by_leader : {false, true}) {
    Script script{
        by_leader ? "path forward 0.8 leader via 0 0 1 0" : "path forward 0.8 via 0 0 1 0", kCalm,
        kChair, 1};
    for (double t = 0.0; t < 1.0; t += kTick) (void)script.steer({}, {1.0, 0.0, 0.0}, t);
    EXPECT_EQ(script.arrived(), by_leader);
  }
}

TEST(RouteOfADriver, IsAddressedByItsLength) {
  const Route route{{{0.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}}};
  EXPECT_EQ(route.length(), 3.0);
  EXPECT_TRUE(route.point_at(2.5).isApprox(Eigen::Vector2d{2.0, 0.5}));
  EXPECT_TRUE(route.point_at(3.5).isApprox(Eigen::Vector2d{2.0, 1.5}));  // straight on
  EXPECT_TRUE(route.point_at(-1.0).isApprox(Eigen::Vector2d{-1.0, 0.0}));
  EXPECT_NEAR(route.nearest({1.2, 0.4}, 0.0, 3.0), 1.2, 1e-12);
  EXPECT_NEAR(route.nearest({2.3, 0.7}, 0.0, 3.0), 2.7, 1e-12);
  EXPECT_NEAR(route.nearest({2.3, 0.7}, 0.0, 1.0), 1.0, 1e-12);  // searched no farther
  EXPECT_NEAR(route.nearest({5.0, 5.0}, 0.0, 9.0), 3.0, 1e-12);
  EXPECT_THROW((Route{{{0.0, 0.0}}}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
