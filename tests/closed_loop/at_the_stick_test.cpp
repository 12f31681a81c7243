// SPDX-License-Identifier: Apache-2.0
// Tests the robot's response to a stick that is pushed, released, moved randomly, or pushed toward
// an obstacle: with each method, compared with manual control.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <spdlog/fmt/ranges.h>

#include "bringup/drive/lockstep.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// The stick from t [s] on, with the dead-man button held.
struct Push {
  double t, linear, angular;
};

constexpr double kAtRest = 0.002;  // [m/s]; nobody sees a base roll back more slowly

class AtTheStick : public ::testing::TestWithParam<const char*> {
 protected:
  static Scenario place(const std::string& map, const std::string& robot, const Pose2& start) {
    Scenario scenario;
    scenario.name = "stick";
    scenario.path = "this test";
    scenario.map = test::source_path(map);
    scenario.robot = test::source_path("bringup/robots/" + robot + ".yaml");
    scenario.start = start;
    scenario.goal = RoamGoal{};
    scenario.slice = {{"z_min", {"0.05", "this test"}}, {"z_max", {"1.15", "this test"}}};
    return scenario;
  }
  static Scenario hall() { return place("maps/hall.bt", "mir100", {-6.0, 0.0, 0.0}); }
  // `duration` [s] of these pushes.
  static std::vector<DriveSample> track_of(Scenario scenario, const std::string& method,
                                           const std::vector<Push>& pushes, double duration) {
    std::vector<double> t, linear, angular;
    for (const Push& push : pushes) {
      t.push_back(push.t);
      linear.push_back(push.linear);
      angular.push_back(push.angular);
    }
    t.push_back(duration);
    linear.push_back(linear.back());
    angular.push_back(angular.back());
    auto& driver = scenario.parameters["driver"];
    driver["driver"] = {"replay", "this test"};
    driver["replay_t"] = {fmt::format("{}", t), "this test"};
    driver["replay_linear"] = {fmt::format("{}", linear), "this test"};
    driver["replay_angular"] = {fmt::format("{}", angular), "this test"};
    scenario.duration = duration;
    return drive_in_lockstep(scenario, {.method = method, .lockstep = true}).track;
  }

  static const DriveSample& at(const std::vector<DriveSample>& track, double t) {
    return *std::find_if(track.begin(), track.end() - 1,
                         [&](const DriveSample& sample) { return sample.t >= t - 1e-6; });
  }
};

// How far the robot goes along x after a moment, and how far it comes back of that.
struct WayToRest {
  double way = 0.0, back = 0.0;  // [m]
};
WayToRest way_to_rest(const std::vector<DriveSample>& track, const DriveSample& from) {
  double farthest = from.X_MB.x;
  for (const DriveSample& sample : track)
    if (sample.t > from.t) farthest = std::max(farthest, sample.X_MB.x);
  return {farthest - from.X_MB.x, farthest - track.back().X_MB.x};
}

TEST_P(AtTheStick, RestStopsTheRobotWhereItStopsByHandAndNothingRollsBack) {
  const std::vector<Push> pushes{{0.0, 1.0, 0.0}, {4.0, 0.0, 0.0}};
  const auto by_hand = track_of(hall(), "manual", pushes, 7.0);
  const auto track = track_of(hall(), GetParam(), pushes, 7.0);
  ASSERT_GT(at(track, 4.0).twist.v, 0.75);
  const WayToRest rest = way_to_rest(track, at(track, 4.0));
  EXPECT_LT(rest.way, way_to_rest(by_hand, at(by_hand, 4.0)).way + 0.05);
  EXPECT_LT(rest.back, 0.005);
  EXPECT_NEAR(track.back().twist.v, 0.0, 1e-3);
}

TEST_P(AtTheStick, ASlightTurnOfTheStickThatIsLetGoDelaysNoStop) {
  const std::vector<Push> still{{0.0, 1.0, 0.0}, {4.0, 0.0, 0.0}};
  const std::vector<Push> turning{{0.0, 1.0, 0.0}, {4.0, 0.0, 0.1}};
  const auto without = track_of(hall(), GetParam(), still, 7.0);
  const auto with = track_of(hall(), GetParam(), turning, 7.0);
  EXPECT_LT(way_to_rest(with, at(with, 4.0)).way,
            way_to_rest(without, at(without, 4.0)).way + 0.02);
}

TEST_P(AtTheStick, ContinuesAfterAShortRest) {
  const std::vector<Push> pushes{{0.0, 1.0, 0.0}, {4.0, 0.0, 0.0}, {4.1, 1.0, 0.0}};
  const auto track = track_of(hall(), GetParam(), pushes, 5.0);
  for (const DriveSample& sample : track) EXPECT_TRUE(sample.t < 4.0 || sample.twist.v > 0.4);
}

TEST_P(AtTheStick, ThrownRoundTurnsTheRobotBackAlmostAsSoonAsByHand) {
  const std::vector<Push> pushes{{0.0, 1.0, 0.0}, {4.0, -1.0, 0.0}};
  const auto backs_after = [&](const std::string& method) {
    for (const DriveSample& sample : track_of(hall(), method, pushes, 6.0))
      if (sample.t > 4.0 && sample.twist.v < -0.01) return sample.t - 4.0;
    return 1e9;
  };
  EXPECT_LT(backs_after(GetParam()), backs_after("manual") + 0.2);
}

// A wheelchair 0.65 m wide before a gap of 0.60 m.
TEST_P(AtTheStick, PushedAtTooNarrowAGapItStopsBeforeItFacingIt) {
  const Scenario gap = place("maps/home.bt", "wheelchair", {4.9, 6.1, 0.0});
  const auto track = track_of(gap, GetParam(), {{0.0, 1.0, 0.0}}, 6.0);
  double turned = 0.0;
  int reversals = 0;
  for (const DriveSample& sample : track) turned = std::max(turned, std::abs(sample.X_MB.theta));
  double last = 0.0;  // [m/s]
  for (const DriveSample& sample : track) {
    if (std::abs(sample.twist.v) < kAtRest) continue;
    if (sample.twist.v * last < 0.0) ++reversals;
    last = sample.twist.v;
  }
  EXPECT_LT(turned, 10.0 * kDegree);
  EXPECT_LE(reversals, 1);
  EXPECT_EQ(track.back().collisions, 0);
  EXPECT_NEAR(track.back().twist.v, 0.0, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Methods, AtTheStick,
                         ::testing::Values("leader", "path", "intention", "blend"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace tandem
