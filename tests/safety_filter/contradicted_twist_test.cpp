// SPDX-License-Identifier: Apache-2.0
// Tests the filter with a base whose odometry has correct poses and a wrong twist.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "safety_filter/scenes.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

constexpr double kFilterPeriod = 0.05;  // [s] of the filter

struct Odometer {
  const char* name;
  std::function<Twist2(const Twist2&, const Pose2& X_WB)> twist;
};

const Odometer kTruth{"truth", [](auto& twist, auto&) { return twist; }};
const Odometer kLies[] = {{"in the world's frame",
                           [](auto& twist, auto& X) {
                             return Twist2{twist.v * std::cos(X.theta), twist.w};
                           }},
                          {"of the wrong sign",
                           [](auto& twist, auto&) {
                             return Twist2{-twist.v, twist.w};
                           }},
                          {"of the wrong sign, turning too",
                           [](auto& twist, auto&) {
                             return Twist2{-twist.v, -twist.w};
                           }},
                          {"zero", [](auto&, auto&) { return Twist2{}; }},
                          {"unsigned", [](auto& twist, auto&) {
                             return Twist2{std::abs(twist.v), std::abs(twist.w)};
                           }}};

// How odometry is published.
struct Wire {
  double period, step;  // [s], [m] to which poses are rounded; 0: exact
};
constexpr Wire kWires[] = {{0.02, 0.0}, {0.1, 0.0}, {0.1, 0.01}, {0.05, 0.01}};

double rounded(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

class Doubted {
 public:
  // `heading`: the robot's initial heading in the odometry frame.
  Doubted(const Odometer& odometer, const Wire& wire, double heading, double a_drive,
          const std::shared_ptr<const StaticMap>& map, unsigned seed)
      : odometer_{odometer},
        wire_{wire},
        X_WO_{0.0, 0.0, heading},
        sim_{base(a_drive), kMir, map, seed} {
    filter_.on_map(map);
  }

  void start_at(const Pose2& X_MB) { sim_.reset(X_MB, 1); }

  Filtered push(const Twist2& command) {
    for (int i = 0; i < 5; ++i) {
      now_ += kFilterPeriod / 5;
      sim_.advance_to(now_);
      if (now_ >= due_ - 1e-9) measure();
    }
    filter_.on_command(command, now_);
    const Filtered out = filter_.update(state_, now_);
    sim_.command(out.twist, now_);
    return out;
  }

  [[nodiscard]] const DiffDriveSim& sim() const { return sim_; }

 private:
  static DiffDriveSimParams base(double a_drive) {
    DiffDriveSimParams params;
    params.drive.a_drive = a_drive;
    params.drive.alpha_drive = 2.0 * a_drive;
    return params;
  }
  void measure() {
    due_ = now_ + wire_.period;
    const OdometryReport report = sim_.odometry();
    Pose2 X_WB = compose(X_WO_, report.X_WB);
    const Twist2 twist = odometer_.twist(report.twist, X_WB);
    X_WB.x = rounded(X_WB.x, wire_.step);
    X_WB.y = rounded(X_WB.y, wire_.step);
    state_ = RobotState{compose(report.X_MW, report.X_WB), twist, now_, X_WB};
    filter_.on_state(*state_, now_);
  }

  const Odometer& odometer_;
  Wire wire_;
  Pose2 X_WO_;
  SafetyFilter filter_{{}, kMir};
  DiffDriveSim sim_;
  std::optional<RobotState> state_;
  double now_ = 0.0, due_ = 0.0;
};

const std::vector<double> kHeadings =
    kInstrumented ? std::vector{1.0} : std::vector{0.0, 1.0, 2.0, std::numbers::pi};  // [rad]
const std::vector<double> kGaps =
    kInstrumented ? std::vector{0.4} : std::vector{0.1, 0.4, 1.0, 3.0};  // [m]

// Drives through an empty hall against its end wall, from afar and from close to it.
TEST(DoubtedTwist, EndsInNoContactWithAWall) {
  for (const Odometer& lie : kLies) {
    for (const Wire& wire : kWires) {
      for (const double a_drive : {0.8, 50.0}) {
        for (const double heading : kHeadings) {
          for (const double gap : kGaps) {
            for (const double v : {0.8, -0.4}) {
              Doubted loop(lie, wire, heading, a_drive, wall_ahead(), 1);
              const double reach = v > 0.0 ? kBumper : kBumper - 2.0 * 0.038;
              loop.start_at({1.5 - reach - gap, 0.0, v > 0.0 ? 0.0 : std::numbers::pi});
              const double start = loop.sim().state().X_MB.x;
              for (int i = 0; i < 160; ++i) (void)loop.push({v, 0.0});
              ASSERT_EQ(loop.sim().contacts().count, 0U)
                  << lie.name << ", " << wire.period << " s, " << wire.step << " m, a " << a_drive
                  << ", heading " << heading << ", gap " << gap << ", v " << v;
              if (gap > 0.5) {
                EXPECT_GT(loop.sim().state().X_MB.x, start + 0.5 * gap) << lie.name << ' ' << gap;
              }
            }
          }
        }
      }
    }
  }
}

// Moves the stick randomly among poles and walls, for 20 s at a time.
TEST(DoubtedTwist, EndsInNoContactUnderAWildStick) {
  double travel = 0.0;
  for (unsigned seed = 1; seed <= samples(40, 8); ++seed) {
    Random random(seed);
    const auto map = random_map(random);
    const Odometer& lie = kLies[seed % std::size(kLies)];
    Doubted loop(lie, kWires[static_cast<std::size_t>(pick(random, 4))],
                 uniform(random, -std::numbers::pi, std::numbers::pi), pick(random, 2) ? 1.0 : 50.0,
                 map, seed);
    Pose2 start;
    if (!find_free_pose(random, *map, loop.sim().footprint(), 0.05, start)) continue;
    loop.start_at(start);
    Twist2 stick;
    Pose2 before = start;
    for (int i = 0; i < 400; ++i) {
      if (pick(random, 12) == 0)
        stick = {uniform(random, -0.6, 0.8), pick(random, 2) ? 0.0 : uniform(random, -1.0, 1.0)};
      (void)loop.push(stick);
      travel += (loop.sim().state().X_MB.position() - before.position()).norm();
      before = loop.sim().state().X_MB;
    }
    EXPECT_EQ(loop.sim().contacts().count, 0U) << seed << ' ' << lie.name;
  }
  EXPECT_GT(travel, samples(20, 4));  // [m]
}

// Correct odometry must cost nothing.
TEST(DoubtedTwist, NeverOccursWithHonestOdometry) {
  for (const Wire& wire : kWires) {
    Doubted loop(kTruth, wire, 2.0, 1.0, wall_ahead(), 1);
    loop.start_at({-3.0, 0.0, 0.0});
    Random random(1);
    for (int i = 0; i < 400; ++i) {
      const double side = (i / 60) % 2 ? 0.4 : -0.3;
      const Filtered out = loop.push({side, uniform(random, -0.5, 0.5)});
      EXPECT_FALSE(out.twist_contradicted) << wire.period << ' ' << wire.step << ' ' << i;
    }
  }
}

TEST(DoubtedTwist, ImpossibleSpeedStopsTheRobotAndIsReported) {
  const Odometer millimetres{"mm/s", [](auto& twist, auto&) {
                               return Twist2{1000.0 * twist.v, twist.w};
                             }};
  Doubted loop(millimetres, kWires[0], 0.0, 1.0, wall_ahead(), 1);
  loop.start_at({-3.0, 0.0, 0.0});
  bool said = false;
  for (int i = 0; i < 20; ++i)
    said = said || loop.push({0.8, 0.0}).reason == FilterReason::kTooFast;
  EXPECT_TRUE(said);
}

// A correction of map → odom moves the robot in the map, not on the ground.
TEST(DoubtedTwist, IsNotCausedByLocaliserCorrections) {
  SafetyFilter filter({}, kMir);
  filter.on_map(wall_ahead());
  for (int i = 0; i < 40; ++i) {
    const double t = 0.05 * i, corrected = i < 20 ? 0.0 : 0.15;
    filter.on_command({0.3, 0.0}, t);
    const Filtered out = filter.update(
        RobotState{
            {0.015 * i - 3.0 + corrected, 0.0, 0.0}, {0.3, 0.0}, t, Pose2{0.015 * i, 0.0, 0.0}},
        t);
    EXPECT_EQ(out.reason, FilterReason::kClear);
    EXPECT_FALSE(out.twist_contradicted);
  }
}

}  // namespace
}  // namespace tandem::test
