// SPDX-License-Identifier: Apache-2.0
// Tests a robot that is already inside the margin, because an obstacle appeared or because of the
// map at its start. No command may bring it further in, and the operator can drive out wherever a
// path certainly does not lead further in.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "safety_filter/adversary.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

const unsigned kScenes = samples(40, 3, 200);
constexpr double kPeriod = 0.05;                       // [s]
constexpr double kBetweenChecks = 0.004;               // [m] half of kCheckSpacing
constexpr double kLeast = kBetweenChecks, kFar = 1.0;  // [m] of clearance: at the start, told apart

// A robot in a world; finds poses inside the filter's margin.
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

// Full stick deflection in all directions.
std::vector<Twist2> sticks(const RobotParams& robot) {
  std::vector<Twist2> all;
  for (const double v : {robot.v_min, 0.0, robot.v_max})
    for (const double share : {-1.0, -0.3, 0.0, 0.3, 1.0})
      if (v != 0.0 || share != 0.0) all.push_back({v, share * robot.w_max});
  return all;
}

// Searches for ways out in small moves, by exact geometry. A move certainly does not lead further
// in if, in each of eight directions, obstacles within the margin recede by at least the possible
// slip and heading error, and all others stay outside it. Since either of v and w may act first,
// each of them alone must satisfy this too.
class SureWays {
 public:
  SureWays(const Scene& scene, double margin) : scene_{scene}, margin_{margin} {}

  [[nodiscard]] bool lead_out(const Pose2& start) const {
    std::set<std::array<long, 3>> seen{cell(start)};
    std::vector<Pose2> open{start};
    while (!open.empty() && seen.size() < kMax) {
      const Pose2 X = open.back();
      open.pop_back();
      const Gaps before = gaps(X);
      if (*std::min_element(before.begin(), before.end()) >= margin_) return true;
      for (const double v : {-1.0, 0.0, 1.0})
        for (const double w : {-1.0, -0.3, 0.0, 0.3, 1.0}) {
          const Twist2 move{v * kPath, w * kTurn};
          const Pose2 X_next = integrate(X, move, 1.0);
          if (!seen.contains(cell(X_next)) && is_sure(X, before, move)) {
            seen.insert(cell(X_next));
            open.push_back(X_next);
          }
        }
    }
    return !open.empty();  // too many to search exhaustively
  }

 private:
  using Gaps = std::array<double, 8>;
  static constexpr double kPath = 0.004, kTurn = 0.008;  // [m], [rad]
  static constexpr double kBeyond = 0.01;  // [m] gaps are measured to this far beyond the margin
  static constexpr std::size_t kMax = 20'000;

  // The resolution is finer than a move, so that distinct poses are searched.
  static std::array<long, 3> cell(const Pose2& X) {
    return {std::lround(X.x / 0.003), std::lround(X.y / 0.003), std::lround(X.theta / 0.006)};
  }
  // Distance from the outline to the nearest cell in each direction.
  [[nodiscard]] Gaps gaps(const Pose2& X) const {
    const Footprint footprint = footprint_of(scene_.robot);
    const double side = scene_.map->grid().resolution, most = margin_ + kBeyond;
    Gaps all;
    all.fill(most);
    for (const auto& p_MC : scene_.map->cells_near(X.position(), circumradius(footprint) + most)) {
      const auto gap = [&](double dx, double dy) {
        return distance_to_square(footprint, {X.x + dx, X.y + dy, X.theta}, p_MC, side);
      };
      const double here = gap(0.0, 0.0);
      if (here >= most) continue;
      const double angle =
          std::atan2(gap(0.0, -1e-6) - gap(0.0, 1e-6), gap(-1e-6, 0.0) - gap(1e-6, 0.0));
      const double eighths = 4.0 * (angle / std::numbers::pi + 1.0);
      auto& nearest = all[static_cast<std::size_t>(eighths) % 8];
      nearest = std::min(nearest, here);
    }
    return all;
  }
  [[nodiscard]] bool is_sure(const Pose2& X, const Gaps& before, const Twist2& move) const {
    return gains(X, before, move) && gains(X, before, {move.v, 0.0}) &&
           gains(X, before, {0.0, move.w});
  }
  [[nodiscard]] bool gains(const Pose2& X, const Gaps& before, const Twist2& move) const {
    const double wheels = scene_.robot.wheel_separation;
    const auto [left, right] = to_wheels(move, wheels);
    const double radius = circumradius(footprint_of(scene_.robot));
    const double cost =
        scene_.params.slip * (0.5 + radius / wheels) * (std::abs(left) + std::abs(right)) +
        scene_.params.heading_error * std::abs(move.v);
    const Gaps after = gaps(integrate(X, move, 1.0));
    for (std::size_t i = 0; i < after.size(); ++i)
      if (after[i] < std::min(before[i], margin_) + cost - 1e-6) return false;
    return true;
  }

  const Scene& scene_;
  double margin_;
};

TEST(InsideTheMargin, SomeCommandLeadsOutWhereAPathIsSafeAndNoneLeadsFurtherIn) {
  int starts = 0, out = 0, nearer_out = 0, sure = 0;
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
    const bool leads_out = most >= loop.filter().hard_margin();
    const bool is_sure = SureWays(scene, loop.filter().hard_margin()).lead_out(*start);
    EXPECT_TRUE(leads_out || !is_sure) << "scene " << seed;
    out += leads_out ? 1 : 0;
    nearer_out += most >= before + 0.002 ? 1 : 0;
    sure += is_sure ? 1 : 0;
  }
  std::printf(
      "%d starts: a stick leads out of %d, nearer to it of %d; a sure way of %d; most lost %.4f "
      "m\n",
      starts, out, nearer_out, sure, most_lost);
  EXPECT_GT(starts, 0.9 * kScenes);
  EXPECT_GE(nearer_out, 0.94 * starts);
  EXPECT_GE(out, 0.9 * starts);
  EXPECT_GE(sure, 0.8 * starts);  // otherwise the search proves nothing
}

TEST(InsideTheMargin, AnAdversaryCannotDriveItFurtherIn) {
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
