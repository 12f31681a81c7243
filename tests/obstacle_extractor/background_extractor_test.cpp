// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/background_extractor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <vector>

#include "obstacle_extractor/fitting_thread.hpp"
#include "obstacle_extractor/worlds.hpp"

namespace tandem {
namespace {

using test::load_world;
using test::project_map;

// A hanging thread fails here rather than by the timeout of the whole test.
class Patience {
 public:
  [[nodiscard]] bool ended() { return std::chrono::steady_clock::now() > end_; }

 private:
  std::chrono::steady_clock::time_point end_ =
      std::chrono::steady_clock::now() + std::chrono::seconds{120};
};

// Polls until there is a result.
std::vector<Obstacle> wait_for(BackgroundExtractor& shapes,
                               const std::shared_ptr<const StaticMap>& map,
                               const Eigen::Vector2d& p_MB) {
  for (Patience patience; !patience.ended();)
    if (auto near = shapes.near(map, p_MB)) return *near;
  ADD_FAILURE() << "nothing was fitted";
  return {};
}

TEST(BackgroundExtractor, GivesTheShapesOfTheExtractor) {
  const auto map = load_world(project_map("corridor"));
  test::FittingThread fitting({});
  BackgroundExtractor& shapes = fitting.shapes;
  Extractor extractor(map, {});
  for (double x = 1.0; x < 14.0; x += 0.5)
    test::expect_same(wait_for(shapes, map, {x, 0.0}), extractor.near({x, 0.0}));
}

// A robot at 1 m/s polls 40 times a second; fits that take 0.9 s each must still finish in time.
TEST(BackgroundExtractor, HasTheNextShapesBeforeTheRobotIsThere) {
  const ExtractorParams params;
  Extractor extractor(load_world(project_map("corridor")), params);
  const auto fit = [&](const Eigen::Vector2d& p) {
    return FittedArea{p, extractor.shapes_near(p, params.range + BackgroundExtractor::kAhead),
                      params.range};
  };
  FittedArea area = fit({1.0, 0.0});
  Eigen::Vector2d asked = area.p_MC;
  int late = 0;
  for (double x = 1.0; x < 14.0; x += 0.025) {
    const Eigen::Vector2d p_MB{x, 0.0};
    const auto shapes = shapes_within(area, p_MB);
    ASSERT_TRUE(shapes) << "at x = " << x;
    test::expect_same(*shapes, extractor.near(p_MB));
    if (late == 0 && (p_MB - asked).norm() >= BackgroundExtractor::kRenew) {
      asked = p_MB;
      late = 36;
    }
    if (late > 0 && --late == 0) area = fit(asked);
  }
}

TEST(BackgroundExtractor, SaysNothingWhereNothingIsFitted) {
  const auto map = load_world(project_map("corridor"));
  Extractor extractor(map, {});
  const FittedArea area{{1.0, 0.0}, extractor.shapes_near({1.0, 0.0}, 6.0), 4.0};
  EXPECT_TRUE(shapes_within(area, {2.9, 0.0}));
  EXPECT_FALSE(shapes_within(area, {3.1, 0.0}));
  EXPECT_FALSE(shapes_within(area, {std::numeric_limits<double>::quiet_NaN(), 0.0}));
  test::FittingThread fitting({});
  BackgroundExtractor& shapes = fitting.shapes;
  EXPECT_FALSE(shapes.near(nullptr, {1.0, 0.0}));
  EXPECT_FALSE(shapes.near(map, {std::numeric_limits<double>::quiet_NaN(), 0.0}));
}

bool are_equal(const std::vector<Obstacle>& a, const std::vector<Obstacle>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.id == y.id && x.p_MO == y.p_MO && x.a == y.a && x.angle == y.angle;
  });
}

TEST(BackgroundExtractor, KeepsTheOldMapsShapesUntilThereAreSomeOfTheNew) {
  const auto corridor = load_world(project_map("corridor")),
             slalom = load_world(project_map("slalom"));
  const Eigen::Vector2d p_MB{3.0, 0.0};
  const ExtractorParams params;
  test::FittingThread fitting(params);
  BackgroundExtractor& shapes = fitting.shapes;
  (void)wait_for(shapes, corridor, p_MB);
  Extractor fresh(corridor, params);  // as the tiles lie
  fresh.update(slalom);
  const auto best = fresh.near(p_MB);
  Patience patience;
  while (true) {  // never nothing, always all cells of one of the two, and in the end the best
    const auto now = shapes.near(slalom, p_MB);
    ASSERT_TRUE(now);
    ASSERT_TRUE(test::uncovered_cells(*corridor, p_MB, params.range, *now) == 0 ||
                test::uncovered_cells(*slalom, p_MB, params.range, *now) == 0);
    if (are_equal(*now, best)) break;
    ASSERT_FALSE(patience.ended());
  }
}

TEST(BackgroundExtractor, GoesOnAsBeforeUntilOtherParametersAreFitted) {
  const auto map = load_world(project_map("corridor"));
  const Eigen::Vector2d p_MB{3.0, 0.0};
  const ExtractorParams near{.range = 1.5}, far{.range = 6.0};
  test::FittingThread fitting(near);
  BackgroundExtractor& shapes = fitting.shapes;
  const auto old = wait_for(shapes, map, p_MB);
  EXPECT_THROW(shapes.set_params({.range = -1.0}), std::invalid_argument);
  shapes.set_params(far);
  const auto fresh = extract(*map, p_MB, far);
  ASSERT_GT(fresh.size(), old.size());
  Patience patience;
  while (true) {  // never nothing, and in the end all
    const auto now = shapes.near(map, p_MB);
    ASSERT_TRUE(now);
    if (now->size() == fresh.size()) {
      test::expect_same(*now, fresh);
      break;
    }
    test::expect_same(*now, old);
    ASSERT_FALSE(patience.ended());
  }
}

TEST(BackgroundExtractor, EndsWhileItFits) {
  const auto map = load_world(project_map("forest"));
  for (int i = 0; i < 20; ++i) {
    test::FittingThread fitting({});
    EXPECT_FALSE(fitting.shapes.near(map, {0.0, 0.0}));
  }
}

}  // namespace
}  // namespace tandem
