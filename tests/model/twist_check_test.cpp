// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/twist_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace tandem {
namespace {

constexpr TwistCheckBounds kBounds{
    .resolution = 0.01, .age = 0.02, .slip = 0.02, .command_delay = 0.02};

double rounded(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

// A robot that follows commands immediately, with its odometry.
class Rider {
 public:
  using Twisted = std::function<Twist2(const Twist2&, const Pose2&)>;

  Rider(double rate, double step, double heading, Twisted twisted)
      : period_{1.0 / rate}, step_{step}, X_{0.0, 0.0, heading}, twisted_{std::move(twisted)} {}

  void drive(const Twist2& twist, double duration) {
    check_.on_command(twist, t_);
    for (double end = t_ + duration; t_ < end - 1e-9;) {
      X_ = integrate(X_, twist, period_);
      t_ += period_;
      said_ = twisted_(twist, X_);
      check_.on_odometry({rounded(X_.x, step_), rounded(X_.y, step_), X_.theta}, said_, t_);
      contradicted_ = contradicted_ || check_.is_contradicted();
    }
  }
  [[nodiscard]] bool was_contradicted() const { return contradicted_; }
  [[nodiscard]] double lowest() const { return said_.v - check_.error(said_).below.v; }
  [[nodiscard]] double highest() const { return said_.v + check_.error(said_).above.v; }
  [[nodiscard]] TwistError error() const { return check_.error(said_); }
  TwistCheck& check() { return check_; }

 private:
  double period_, step_;
  Pose2 X_;
  Twisted twisted_;
  TwistCheck check_{kBounds};
  double t_ = 0.0;
  Twist2 said_;
  bool contradicted_ = false;
};

Twist2 honest(const Twist2& twist, const Pose2&) { return twist; }
Twist2 in_the_world(const Twist2& twist, const Pose2& X) {
  return {twist.v * std::cos(X.theta), twist.w};
}

TEST(TwistCheck, HasNoDoubtInHonestOdometryOfAnyRateAndResolution) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> v(-0.8, 0.8), w(-1.0, 1.0), time(0.1, 2.0);
  for (const double rate : {10.0, 20.0, 50.0, 200.0}) {
    for (const double step : {0.0, 0.001, 0.01}) {
      Rider rider(rate, step, 2.0, honest);
      for (int i = 0; i < 100; ++i) rider.drive({v(random), w(random)}, time(random));
      EXPECT_FALSE(rider.was_contradicted()) << rate << ' ' << step;
    }
  }
}

TEST(TwistCheck, SeesATwistInTheWorldsFrameOfTheWrongSignZeroAndUnsigned) {
  const struct {
    const char* name;
    double heading, v;
    Rider::Twisted twisted;
  } lies[] = {{"world", std::numbers::pi, 0.8, in_the_world},
              {"world, across", 0.5 * std::numbers::pi, 0.8, in_the_world},
              {"wrong sign", 0.0, 0.8,
               [](auto& twist, auto&) {
                 return Twist2{-twist.v, twist.w};
               }},
              {"wrong sign, back", 0.0, -0.4,
               [](auto& twist, auto&) {
                 return Twist2{-twist.v, twist.w};
               }},
              {"zero", 0.0, 0.8, [](auto&, auto&) { return Twist2{}; }},
              {"unsigned", 1.0, -0.4,
               [](auto& twist, auto&) {
                 return Twist2{std::abs(twist.v), twist.w};
               }},
              {"half", 0.0, 0.8, [](auto& twist, auto&) {
                 return Twist2{0.5 * twist.v, twist.w};
               }}};
  for (const auto& lie : lies) {
    for (const double rate : {10.0, 50.0}) {
      Rider rider(rate, 0.01, lie.heading, lie.twisted);
      rider.drive({lie.v, 0.0}, 0.6);
      EXPECT_TRUE(rider.check().is_contradicted()) << lie.name << ' ' << rate;
      EXPECT_LE(rider.lowest(), lie.v + 1e-9) << lie.name << ' ' << rate;
      EXPECT_GE(rider.highest(), lie.v - 1e-9) << lie.name << ' ' << rate;
      rider.drive({}, 1.5);
      EXPECT_FALSE(rider.check().is_contradicted()) << lie.name;  // at rest all sources agree
    }
  }
}

TEST(TwistCheck, SeesATurnRateOfTheWrongSign) {
  Rider rider(10.0, 0.01, 0.0, [](auto& twist, auto&) { return Twist2{twist.v, -twist.w}; });
  rider.drive({0.3, 0.8}, 0.6);
  EXPECT_TRUE(rider.check().is_contradicted());
  EXPECT_GE(rider.error().above.w, 1.6);
  EXPECT_EQ(rider.error().above.v, 0.0);
}

// The check by poses needs a window of time; until then the commands are compared.
TEST(TwistCheck, DoubtsATwistAgainstTheCommandUntilThePosesDecide) {
  Rider rider(50.0, 0.0, std::numbers::pi, in_the_world);
  rider.drive({}, 1.0);
  rider.drive({0.8, 0.0}, 0.02);
  EXPECT_FALSE(rider.check().is_contradicted());
  EXPECT_NEAR(rider.highest(), 0.8, 1e-9);
  Rider honestly(50.0, 0.0, std::numbers::pi, honest);
  honestly.drive({}, 1.0);
  honestly.drive({0.8, 0.0}, 0.02);
  EXPECT_EQ(honestly.error(), TwistError{});
}

TEST(TwistCheck, ComparesNothingAcrossASilence) {
  TwistCheck check(kBounds);
  check.on_odometry({}, {}, 0.0);
  check.on_odometry({1.0, 0.0, 0.0}, {}, 0.4);  // it rolled in between
  check.on_odometry({1.0, 0.0, 0.0}, {}, 0.6);
  EXPECT_FALSE(check.is_contradicted());
  check.on_odometry({1.0, 0.0, 0.0}, {}, 0.0);  // the clock was set back
  EXPECT_FALSE(check.is_contradicted());
}

TEST(TwistCheck, ReportsTheSpeedProvenByThePoses) {
  TwistCheck check(kBounds);
  for (int i = 0; i <= 10; ++i) check.on_odometry({-0.3 * i, 0.0, 0.0}, {}, 0.1 * i);
  EXPECT_GT(check.least_speed().v, 2.5);
  EXPECT_LE(check.least_speed().v, 3.0);
  EXPECT_EQ(check.least_speed().w, 0.0);
}

}  // namespace
}  // namespace tandem
