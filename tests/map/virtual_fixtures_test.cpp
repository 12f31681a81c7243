// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/virtual_fixtures.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <stdexcept>

namespace tandem {
namespace {

Grid free_grid(int width, int height) {
  return {0.1,
          {0.0, 0.0},
          width,
          height,
          std::vector<Cell>(static_cast<std::size_t>(width * height), Cell::kFree)};
}

VirtualFixtures region(std::vector<Eigen::Vector2d> p_MV) {
  return {{{"region", std::move(p_MV)}}, {}};
}

class FixtureFile : public ::testing::Test {
 protected:
  ~FixtureFile() override { std::filesystem::remove(path_); }

  VirtualFixtures load(const std::string& text) {
    std::ofstream{path_} << text;
    return load_virtual_fixtures(path_);
  }
  void expect_complaint(const std::string& text, const std::string& about) {
    try {
      (void)load(text);
      FAIL() << "accepted: " << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string{error.what()}.find(about), std::string::npos) << error.what();
      EXPECT_NE(std::string{error.what()}.find(path_.string()), std::string::npos);
    }
  }

  std::filesystem::path path_ =
      std::filesystem::path(testing::TempDir()) / ("fixtures_" + std::to_string(getpid()));
};

TEST_F(FixtureFile, IsRead) {
  const VirtualFixtures fixtures =
      load("forbidden:\n  - {name: mat, polygon: [[0, 0], [1, 0], [1, 2]]}\n");
  ASSERT_EQ(fixtures.forbidden.size(), 1U);
  EXPECT_EQ(fixtures.forbidden[0].name, "mat");
  EXPECT_EQ(fixtures.forbidden[0].p_MV.at(2), Eigen::Vector2d(1.0, 2.0));
}

TEST_F(FixtureFile, MayGuideToo) {
  const VirtualFixtures fixtures = load(
      "guidance:\n  - {name: lane, line: [[0, 0], [4, 0], [4, 3]], strength: 0.8}\n"
      "  - {line: [[0, 1], [1, 1]], reach: 2}\n");
  EXPECT_TRUE(fixtures.forbidden.empty());
  ASSERT_EQ(fixtures.guidance.size(), 2U);
  EXPECT_EQ(fixtures.guidance[0].name, "lane");
  EXPECT_EQ(fixtures.guidance[0].p_MV.size(), 3U);
  EXPECT_EQ(fixtures.guidance[0].strength, 0.8);
  EXPECT_EQ(fixtures.guidance[1].reach, 2.0);
}

TEST_F(FixtureFile, ThatIsWrongIsRefusedWithItsLine) {
  expect_complaint(
      "forbiden: []\n",
      ":1: unknown key `forbiden`; valid keys: forbidden, guidance; did you mean `forbidden`?");
  expect_complaint("forbidden: []\nforbidden: []\n",
                   ":2: `forbidden` is given twice, first in line 1");
  expect_complaint("guidance:\n  - {line: [[0, 0], [1, 0]], reach: 1, reach: 2}\n", "given twice");
  expect_complaint("forbidden: 3\n", "expected a list");
  expect_complaint("forbidden:\n  - {polygon: [[0, 0], [1, 0]]}\n",
                   ":2: expected three or more points");
  expect_complaint("forbidden:\n  - {polygon: [[0, 0], [1, x], [1, 1]]}\n", "expected a number");
  expect_complaint("forbidden:\n  - {polygon: [[0, 0], [.nan, 1], [1, 1]]}\n", "outside");
  expect_complaint("guidance:\n  - {line: [[0, 0]]}\n", ":2: expected two or more points");
  expect_complaint("guidance:\n  - {line: [[0, 0], [1, 0]], strength: 2}\n", "outside");
  EXPECT_THROW((void)load_virtual_fixtures("/nowhere.yaml"), std::invalid_argument);
}

TEST(Forbidden, RegionOccupiesEveryCellItReachesInto) {
  std::mt19937 random{3};
  std::uniform_real_distribution<double> at(0.5, 4.5), share(0.0, 1.0);
  for (int n = 0; n < 50; ++n) {
    const Eigen::Vector2d a{at(random), at(random)}, b{at(random), at(random)},
        c{at(random), at(random)};
    const Grid grid = with_forbidden(free_grid(50, 50), region({a, b, c}));
    for (int i = 0; i < 200; ++i) {  // any point of the triangle
      double s = share(random), t = share(random);
      if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
      const Eigen::Vector2d p = a + s * (b - a) + t * (c - a);
      EXPECT_EQ(grid.at(static_cast<int>(p.x() / 0.1), static_cast<int>(p.y() / 0.1)),
                Cell::kOccupied);
    }
  }
}

TEST(Forbidden, RegionLeavesTheRestAsItWas) {
  Grid before = free_grid(50, 50);
  before.cells[before.index(2, 3)] = Cell::kOccupied;
  const Grid grid = with_forbidden(before, region({{2, 2}, {3, 2}, {3, 3}, {2, 3}}));
  EXPECT_EQ(grid.at(2, 3), Cell::kOccupied);
  int occupied = 0;
  for (int iy = 0; iy < 50; ++iy)
    for (int ix = 0; ix < 50; ++ix) {
      if (grid.at(ix, iy) == Cell::kOccupied) ++occupied;
      if (ix < 18 || ix > 31 || iy < 18 || iy > 31) {
        EXPECT_EQ(grid.at(ix, iy), before.at(ix, iy));
      }
    }
  EXPECT_LE(occupied, 1 + 12 * 12);
}

TEST(Forbidden, ConcaveRegionKeepsItsBayFree) {
  const Grid grid = with_forbidden(
      free_grid(50, 50), region({{1, 1}, {4, 1}, {4, 4}, {3, 4}, {3, 2}, {2, 2}, {2, 4}, {1, 4}}));
  EXPECT_EQ(grid.at(25, 30), Cell::kFree);
  EXPECT_EQ(grid.at(15, 30), Cell::kOccupied);
}

TEST(Forbidden, RegionBeyondTheMapMakesItGrow) {
  const Grid before = free_grid(20, 20);
  const Grid grid = with_forbidden(before, region({{-1.05, 0.5}, {-0.5, 0.5}, {2.75, 1.5}}));
  EXPECT_LE(grid.origin.x(), -1.05);
  EXPECT_GE(grid.origin.x() + 0.1 * grid.width, 2.75);
  const int shift = static_cast<int>(std::lround(-grid.origin.x() / 0.1));
  EXPECT_EQ(grid.at(shift + 1, 18), Cell::kFree);
  EXPECT_EQ(grid.at(0, 18), Cell::kUnknown);
  EXPECT_THROW((void)with_forbidden(before, region({{9e3, 0}, {0, 9e3}, {-9e3, -9e3}})),
               std::runtime_error);
}

}  // namespace
}  // namespace tandem
