// SPDX-License-Identifier: Apache-2.0
// A robot that is too close already, for something appeared beside it or the map says so of its
// start: whoever steers gets out of nearly all such places, and nobody gets it further in.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

#include "adversary.hpp"

namespace tandem::test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr unsigned kScenes = 10;
#else
constexpr unsigned kScenes = 200;
#endif
constexpr double kPeriod = 0.05;                       // [s]
constexpr double kBetweenChecks = 0.004;               // [m] half of kCheckSpacing
constexpr double kLeast = kBetweenChecks, kFar = 1.0;  // [m] of clearance: at the start, told apart

// A robot in a world, in which poses inside the filter's margin are found.
struct Scene {
  Random random;
  SafetyFilterParams params = {};
  RobotParams robot;
  std::shared_ptr<const StaticMap> map;

  explicit Scene(unsigned seed)
      : random(seed), robot{random_robot(random)}, map{random_map(random)} {}

  [[nodiscard]] double clearance(const Pose2& X_MB) const {
    return map->clearance(footprint_of(robot), X_MB, kFar);
  }
  [[nodiscard]] std::optional<Pose2> pose_inside(double margin) {
    for (int attempt = 0; attempt < 5000; ++attempt) {
      const Pose2 X_MB{uniform(random, -2.2, 2.2), uniform(random, -2.2, 2.2),
                       uniform(random, -std::numbers::pi, std::numbers::pi)};
      const double gap = clearance(X_MB);
      if (gap > kLeast && gap < margin) return X_MB;
    }
    return std::nullopt;
  }
};

// The stick held to its edge, every way.
std::vector<Twist2> sticks(const RobotParams& robot) {
  std::vector<Twist2> all;
  for (const double v : {robot.v_min, 0.0, robot.v_max})
    for (const double share : {-1.0, -0.3, 0.0, 0.3, 1.0})
      if (v != 0.0 || share != 0.0) all.push_back({v, share * robot.w_max});
  return all;
}

TEST(InsideTheMargin, SomeStickMostlyLeadsOutAndNoneFurtherIn) {
  int starts = 0, out = 0, nearer_out = 0;
  double most_lost = 0.0;
  for (unsigned seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    DiffDriveSimParams base;
    base.max_step = 0.01;
    ClosedLoop loop(scene.params, scene.robot, base, scene.map, scene.random);
    const auto start = scene.pose_inside(loop.filter().hard_margin());
    if (!start) continue;
    ++starts;
    const double before = scene.clearance(*start);
    double most = before;
    for (const Twist2& stick : sticks(scene.robot)) {
      loop.start_at(*start);
      for (int i = 0; i < 40; ++i) (void)loop.tick(stick, kPeriod);
      most = std::max(most, scene.clearance(loop.sim().state().X_MB));
      most_lost = std::max(most_lost, before - loop.sim().min_clearance());
      ASSERT_GE(loop.sim().min_clearance(), before - kBetweenChecks)
          << "scene " << seed << ", stick " << stick.v << ", " << stick.w;
    }
    out += most >= loop.filter().hard_margin() ? 1 : 0;
    nearer_out += most >= before + 0.002 ? 1 : 0;
  }
  std::printf("%d starts: a stick leads out of %d, nearer to it of %d; most lost %.4f m\n", starts,
              out, nearer_out, most_lost);
  EXPECT_GT(starts, 0.9 * kScenes);
  // Where no motion gains clearance the pose's error may have used up what there is: it stands.
  EXPECT_GE(nearer_out, 0.97 * starts);
  EXPECT_GE(out, 0.9 * starts);
}

TEST(InsideTheMargin, MaliceGetsItNoFurtherIn) {
  for (unsigned seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    ClosedLoop loop(scene.params, scene.robot, random_base(scene.random, scene.params), scene.map,
                    scene.random);
    const auto start = scene.pose_inside(loop.filter().hard_margin());
    if (!start) continue;
    const double before = scene.clearance(*start);
    loop.start_at(*start);
    Adversary adversary(static_cast<Malice>(seed % kMalices), scene.robot, scene.random);
    for (int i = 0; i < 200; ++i)
      (void)loop.tick(
          adversary.command(loop.sim().state().X_MB, loop.sim().footprint(), *scene.map), kPeriod);
    ASSERT_EQ(loop.sim().contacts().count, 0u) << "scene " << seed;
    ASSERT_GE(loop.sim().min_clearance(), before - kBetweenChecks) << "scene " << seed;
  }
}

}  // namespace
}  // namespace tandem::test
